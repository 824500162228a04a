#include "afferent/neurons/dense_plan.hpp"

#include <gtest/gtest.h>

#include <chrono>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

using std::chrono::milliseconds;

// With tau_m = 10 ms, tau_g = 100 ms and Δg = 0.06 the largest conductance is 3 + 5 · 0.06 = 3.3, and the
// terms of a crossing's series grow to e^5 in a step of 5 / 4.3 = 1.163 tau_m, or 11.63 ms.
TEST(DensePlan, CutsAScanIntervalIntoAsFewStepsAsItsSeriesBears) {
    const LifParameters parameters{.tau_m_ms = 10, .tau_g_ms = 100, .delta_g = 0.06};
    for (const auto& [interval_ms, steps] :
         {std::pair{1, 1}, {11, 1}, {12, 2}, {23, 2}, {24, 3}, {34, 3}, {35, 4}, {46, 4}}) {
        const dense::Plan plan = dense::plan(parameters, milliseconds(interval_ms));
        EXPECT_EQ(plan.steps, steps) << interval_ms << " ms";
        EXPECT_DOUBLE_EQ(plan.model.step, interval_ms / 10.0 / steps);
    }
    EXPECT_THROW(dense::plan(parameters, milliseconds(47)), ParameterError);
}

// Without adaptation a crossing has a closed form, for any interval.
TEST(DensePlan, CutsNoIntervalOfNeuronsThatDoNotAdapt) {
    EXPECT_EQ(dense::plan({.tau_m_ms = 10, .delta_g = 0}, milliseconds(1000)).steps, 1);
}

}  // namespace
}  // namespace afferent
