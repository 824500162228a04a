#include "afferent/decoders/grip_estimator.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "afferent/decoders/spike_rate.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "tests/since_start.hpp"

namespace afferent {
namespace {

// 10 Hz at 1 N, 100 Hz at 10 N.
ForceRateCurve straight() { return ForceRateCurve({{0.1, 0}, {1, 10}, {10, 100}}); }

SpikeRate heard(std::size_t addresses, const std::vector<Event>& events) {
    SpikeRate rate(addresses, 60ms);
    rate.observe(at(0ms), at(60ms), events);
    rate.advance(at(60ms));
    return rate;
}

TEST(ForceRateCurve, InvertsItself) {
    const ForceRateCurve curve = straight();
    for (const double force : {0.5, 1.0, 3.7, 10.0})
        EXPECT_NEAR(curve.force_n(curve.rate_hz(force)), force, 1e-12);
    EXPECT_DOUBLE_EQ(curve.rate_hz(3.7), 37);
    EXPECT_DOUBLE_EQ(curve.force_n(37), 3.7);
    EXPECT_DOUBLE_EQ(curve.rate_hz(0.55), 5);
    EXPECT_EQ(curve.rate_hz(0.05), 0);
    EXPECT_EQ(curve.force_n(0), 0) << "silence means no force, not the force at which firing begins";
    EXPECT_EQ(curve.force_n(1000), 10);
    EXPECT_THROW(ForceRateCurve({{1, 5}, {2, 5}}), ParameterError);
}

TEST(GripEstimator, InvertsTheSumOfTheRates) {
    // Three events in 60 ms from two neurons: 50 Hz in sum, 5 N on the curve of the sum.
    const SpikeRate rate = heard(2, {{at(10ms), 0}, {at(20ms), 1}, {at(30ms), 0}});
    const Estimate estimate = GripEstimator(straight(), {1, 1})(rate);
    EXPECT_NEAR(estimate.force_n, 5, 1e-12);
    EXPECT_NEAR(estimate.rate_hz, 25, 1e-12);
    // sqrt(2/6)/60 ms = 9.6 Hz, 10 Hz to a newton.
    EXPECT_NEAR(estimate.sigma_n, std::sqrt(2.0 / 6) / 0.060 / 10, 1e-9);
}

TEST(GripEstimator, CountsNeuronsThatFireTogetherAsOne) {
    std::vector<Event> events;
    for (const Duration time : {10ms, 30ms, 50ms})
        for (Address address = 0; address < 9; ++address) events.push_back({at(time), address});
    const SpikeRate rate = heard(9, events);
    const double one_hz = std::sqrt(1.0 / 6) / 0.060;
    // The curve of nine is nine times as steep, 90 Hz to a newton.
    const ForceRateCurve nine({{0.1, 0}, {1, 90}, {10, 900}});
    EXPECT_NEAR(GripEstimator(nine, {9})(rate).sigma_n, one_hz / 10, 1e-9);
    EXPECT_NEAR(GripEstimator(nine, {4, 5})(rate).sigma_n, std::sqrt(16 + 25) * one_hz / 90, 1e-9);

    // The same where each is inverted by itself: those of one curve are alike.
    std::vector<GripEstimator::Neuron> alike, unlike;
    for (Address address = 0; address < 9; ++address) {
        alike.push_back({address, 0, 1.0});
        unlike.push_back({address, address, 1.0});
    }
    EXPECT_NEAR(GripEstimator({straight()}, alike)(rate).sigma_n, one_hz / 10, 1e-9);
    EXPECT_NEAR(GripEstimator(std::vector(9, straight()), unlike)(rate).sigma_n, one_hz / 10 / 3, 1e-9);
}

TEST(GripEstimator, WeighsNeuronsByTheirShareWhereEachIsInvertedByItself) {
    const SpikeRate rate = heard(2, {{at(10ms), 0}, {at(20ms), 0}, {at(30ms), 0}});
    GripEstimator estimator({straight(), straight()}, {{0, 0, 0.75}, {1, 1, 0.25}});
    EXPECT_NEAR(estimator(rate).force_n, 0.75 * 5, 1e-12);
}

// 50 Hz from neurons whose full scales are reached at 50 Hz and at 60 Hz; a silent one counts for neither.
TEST(GripEstimator, IsSaturatedWhereThreeQuartersOfTheShareThatFiresAreAtFullScale) {
    std::vector<Event> events;
    for (const Duration time : {10ms, 30ms, 50ms})
        for (Address address = 0; address < 2; ++address) events.push_back({at(time), address});
    const SpikeRate rate = heard(3, events);
    const auto told = [&](double share) {
        const FullScale reached{.rate_hz = 50, .reading_n = 7}, far{.rate_hz = 600, .reading_n = 12};
        return GripEstimator({straight()},
                             {{0, 0, share, reached}, {1, 0, 0.5 - share, far}, {2, 0, 0.5, far}})(rate);
    };
    const Estimate most = told(0.375);
    EXPECT_EQ(most.doubt, Doubt::saturated);
    EXPECT_NEAR(most.force_n, 0.375 * 7 + 0.125 * 5, 1e-9) << "the full scale, and what the other fires at";
    EXPECT_NE(told(0.37).doubt, Doubt::saturated);
}

TEST(GripEstimator, HoldsItsEstimateAndDoubtsItWhereNothingIsKnown) {
    SpikeRate rate = heard(1, {{at(10ms), 0}, {at(40ms), 0}});
    GripEstimator estimator(straight(), {1});
    const Estimate before = estimator(rate);
    rate.advance(at(500ms));
    const Estimate after = estimator(rate);
    EXPECT_EQ(after.force_n, before.force_n);
    EXPECT_EQ(after.sigma_n, 10);
}

TEST(GripEstimator, IsLessCertainTheLessIsKnown) {
    SpikeRate rate = heard(1, {{at(30ms), 0}, {at(50ms), 0}});
    GripEstimator estimator(straight(), {1});
    const double sure = estimator(rate).sigma_n;
    rate.advance(at(80ms));  // of 60 ms, 20 are unknown
    EXPECT_GT(estimator(rate).sigma_n, sure);
}

TEST(GripEstimator, RefusesToReadNoNeuron) {
    EXPECT_THROW(GripEstimator(straight(), {0}), ParameterError);
    EXPECT_THROW(GripEstimator({straight()}, std::vector{GripEstimator::Neuron{0, 0, 0.0}}), ParameterError);
}

}  // namespace
}  // namespace afferent
