#include "afferent/neurons/dense_plan.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace afferent {
namespace {

using std::chrono::milliseconds;

// With tau_m = 10 ms, tau_g = 100 ms and Δg = 0.06 the largest conductance is 3 + 5 · 0.06 = 3.3, and the
// terms of a crossing's series grow to e^5 in a step of 5 / 4.3 = 1.163 tau_m, or 11.63 ms.
TEST(DensePlan, CutsAScanIntervalIntoAsFewStepsAsItsSeriesBears) {
    const LifParameters parameters{.tau_m_ms = 10, .tau_g_ms = 100, .delta_g = 0.06};
    for (const auto& [interval_ms, steps] :
         {std::pair{1, 1}, {11, 1}, {12, 2}, {23, 2}, {24, 3}, {34, 3}, {35, 4}, {46, 4}, {47, 5}, {93, 8}}) {
        const dense::Plan plan = dense::plan(parameters, milliseconds(interval_ms));
        EXPECT_EQ(plan.steps, steps) << interval_ms << " ms";
        EXPECT_TRUE(plan.series);
        EXPECT_DOUBLE_EQ(plan.model.step, interval_ms / 10.0 / steps);
    }
    EXPECT_FALSE(dense::plan(parameters, milliseconds(94)).series);
}

// Steps of 5 / (1 + 3 + 5 Δg) tau_m, with Δg rounded up to a quarter of an octave.
TEST(DensePlan, PutsNeuronsWhoseStepsAreAboutAsManyInOneClass) {
    const auto class_of = [](double delta_g, int interval_ms) {
        return dense::steps_class({.tau_m_ms = 10, .tau_g_ms = 100, .delta_g = delta_g},
                                  milliseconds(interval_ms));
    };
    EXPECT_EQ(class_of(0.06, 5), 1);
    EXPECT_EQ(class_of(1.1, 5), 1);  // as 1.19: 0.5 · 9.9 / 5
    EXPECT_EQ(class_of(1.3, 5), 2);  // as 1.41: 0.5 · 11.1 / 5
    EXPECT_EQ(class_of(4, 5), 4);    // 0.5 · 24 / 5
    EXPECT_EQ(class_of(13, 5), 8);   // as 13.5: 0.5 · 71 / 5
    EXPECT_EQ(class_of(16, 5), 16);  // 0.5 · 84 / 5: none
    EXPECT_EQ(class_of(1e9, 5), 16);
    EXPECT_EQ(class_of(0, 500), 1);
}

TEST(DensePlan, DependsOnWhatASweepComputesWithAlone) {
    const LifParameters one = dense::planned({.v_th_mv = -50, .delta_g = 0.06, .refractory_ms = 2});
    EXPECT_EQ(one, dense::planned({.v_th_mv = -40, .delta_g = 0.061}));
    EXPECT_EQ(one.delta_g, 0.0625);
    EXPECT_NE(one, dense::planned({.tau_m_ms = 9, .delta_g = 0.06}));
    EXPECT_EQ(dense::planned({.delta_g = 1.7e308}).delta_g, 1.7e308) << "cannot be rounded up";
}

// Too stiff for the series: the polynomials serve as far as they hold, in the end for nobody.
TEST(DensePlan, KeepsThePolynomialsOfStiffNeurons) {
    const dense::Plan stiff = dense::plan({.tau_g_ms = 0.01, .delta_g = 30}, milliseconds(5));
    EXPECT_FALSE(stiff.series);
    EXPECT_EQ(stiff.steps, 1);
    EXPECT_EQ(stiff.model.far.g_max, 123);  // 3 + 4 Δg
    const dense::Plan strong = dense::plan({.tau_g_ms = 50, .delta_g = 1000}, milliseconds(5));
    EXPECT_FALSE(strong.series);
    EXPECT_GT(strong.model.far.g_max, 1);
    EXPECT_LT(strong.model.far.g_max, 4003);
    // However large Δg is, a plan is made.
    EXPECT_FALSE(dense::plan({.delta_g = 1.7e308}, milliseconds(5)).series);
}

// Without adaptation a crossing has a closed form, for any interval.
TEST(DensePlan, CutsNoIntervalOfNeuronsThatDoNotAdapt) {
    EXPECT_EQ(dense::plan({.tau_m_ms = 10, .delta_g = 0}, milliseconds(1000)).steps, 1);
}

}  // namespace
}  // namespace afferent
