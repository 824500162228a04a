#include "afferent/decoders/afferent_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/decoders/afferents.hpp"

namespace afferent {
namespace {

double rising_n(double time_s) { return 4 + 3 * std::sin(2 * time_s); }

std::vector<TimePoint> times_of(const std::vector<Event>& events) {
    std::vector<TimePoint> times;
    for (const Event& event : events) times.push_back(event.time);
    return times;
}

ForceTrace trace(Duration end) {
    ForceTrace points;
    for (Duration time = 0ms; time <= end; time += 10ms)
        points.push_back({seconds(time), rising_n(seconds(time))});
    return points;
}

TEST(AfferentFit, FindsGainAndBiasFromSpikesAndForce) {
    LifParameters adapting{.tau_g_ms = 500, .delta_g = 0.03};
    LifParameters refractory{.refractory_ms = 2};
    for (const NeuronModel& neuron :
         {NeuronModel(LifParameters()), NeuronModel(adapting), NeuronModel(refractory)}) {
        const DecodedAfferents::Group group{neuron, 2.5, 13};
        const auto spikes = times_of(fired(group, 5s, rising_n));
        ASSERT_GT(spikes.size(), 50U);
        // The force was held for a millisecond each.
        const auto samples = drive_samples(neuron, spikes, trace(5s), 500us);
        ASSERT_EQ(samples.size(), spikes.size() - 1);
        const auto fit = fit_drive(samples);
        ASSERT_TRUE(fit);
        // What remains is the force's bend between points 10 ms apart, 1e-4 N.
        EXPECT_NEAR(fit->gain_mv_per_n, 2.5, 0.005);
        EXPECT_NEAR(fit->bias_mv, 13, 0.02);
        EXPECT_LT(fit->residual_mv, 0.02);
    }
}

TEST(AfferentFit, IsALineByLeastSquares) {
    const std::vector<DriveSample> samples{{0, 1}, {1, 4}, {2, 5}, {3, 8}};
    const auto fit = fit_drive(samples);
    ASSERT_TRUE(fit);
    // By the normal equations: slope 11/5, intercept 4.5 − 2.2 · 1.5, residuals −0.2, 0.6, −0.6, 0.2.
    EXPECT_DOUBLE_EQ(fit->gain_mv_per_n, 2.2);
    EXPECT_NEAR(fit->bias_mv, 1.2, 1e-12);
    EXPECT_NEAR(fit->residual_mv, std::sqrt(0.8 / 4), 1e-12);
    EXPECT_EQ(fit->samples, 4U);
}

TEST(AfferentFit, NeedsForcesThatDiffer) {
    EXPECT_FALSE(fit_drive(std::vector<DriveSample>{{1, 2}, {2, 3}}));
    EXPECT_FALSE(fit_drive(std::vector<DriveSample>(10, {1.1, 2})));
    EXPECT_FALSE(fit_drive({}));
}

}  // namespace
}  // namespace afferent
