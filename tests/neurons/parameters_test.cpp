#include "afferent/neurons/parameters.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

std::string refusal(const LifParameters& parameters) {
    try {
        parameters.check();
    } catch (const ParameterError& error) {
        return error.what();
    }
    return "accepted";
}

TEST(LifParameters, AcceptsTheDefaults) { EXPECT_EQ(refusal({}), "accepted"); }

TEST(LifParameters, NamesFieldRuleAndValue) {
    EXPECT_EQ(refusal({.tau_m_ms = -10}), "tau_m_ms must be > 0, is -10");
    EXPECT_EQ(refusal({.tau_m_ms = 0}), "tau_m_ms must be > 0, is 0");
    EXPECT_EQ(refusal({.tau_g_ms = 0}), "tau_g_ms must be > 0, is 0");
    EXPECT_EQ(refusal({.v_r_mv = -50, .v_th_mv = -50}), "v_th_mv must be > v_r_mv, is -50");
    EXPECT_EQ(refusal({.v_th_mv = -50, .e_k_mv = -50}), "e_k_mv must be < v_th_mv, is -50");
    EXPECT_EQ(refusal({.delta_g = -0.5}), "delta_g must be >= 0, is -0.5");
    EXPECT_EQ(refusal({.refractory_ms = -1}), "refractory_ms must be >= 0, is -1");
}

TEST(LifParameters, AcceptsWhatIsAsLargeAsCanBe) {
    EXPECT_EQ(refusal({.v_th_mv = 1e300}), "accepted");
    EXPECT_EQ(refusal({.v_r_mv = -1e300, .e_k_mv = -1e300}), "accepted");
    EXPECT_EQ(refusal({.v_th_mv = 1.1e300}), "v_th_mv must be at most 1e300 in size, is 1.1e+300");
    EXPECT_EQ(refusal({.v_r_mv = -1.1e300}), "v_r_mv must be at most 1e300 in size, is -1.1e+300");
    EXPECT_EQ(refusal({.e_k_mv = -1.1e300}), "e_k_mv must be at most 1e300 in size, is -1.1e+300");
}

TEST(LifParameters, RefusesWhatIsNotFinite) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    constexpr double infinity = std::numeric_limits<double>::infinity();
    for (const double bad : {nan, infinity, -infinity}) {
        EXPECT_NE(refusal({.tau_m_ms = bad}), "accepted");
        EXPECT_NE(refusal({.tau_g_ms = bad}), "accepted");
        EXPECT_NE(refusal({.v_r_mv = bad}), "accepted");
        EXPECT_NE(refusal({.v_th_mv = bad}), "accepted");
        EXPECT_NE(refusal({.e_k_mv = bad}), "accepted");
        EXPECT_NE(refusal({.delta_g = bad}), "accepted");
        EXPECT_NE(refusal({.refractory_ms = bad}), "accepted");
    }
}

}  // namespace
}  // namespace afferent
