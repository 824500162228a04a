#include "afferent/decoders/inverse_interval.hpp"

#include <gtest/gtest.h>

#include "afferent/runtime/parameter_error.hpp"
#include "tests/decoders/afferents.hpp"

namespace afferent {
namespace {

DecodedAfferents fingertip() {
    DecodedAfferents afferents{.addresses = 1, .largest_grip_n = 20};
    afferents.add(0, group_with(2), 1);
    return afferents;
}

TEST(InverseInterval, IsTheReciprocalOfTheLastInterval) {
    InverseInterval decoder({}, fingertip());
    const std::vector<Event> events = {{at(10ms), 0}, {at(50ms), 0}, {at(70ms), 0}};
    decoder.observe(at(0ms), at(75ms), events);
    const Estimate estimate = decoder.estimate(at(75ms));
    EXPECT_DOUBLE_EQ(estimate.rate_hz, 50);
    // The curve is interpolated, to some 1e-4 here.
    EXPECT_NEAR(group_with(2).rate_hz(RateKind::steady, estimate.force_n), 50, 0.05);
}

// Just after a spike, sigma is by how much the rate has changed from the interval before, and at least by
// what silence allows.
TEST(InverseInterval, IsAsUncertainAsTheRateHasChanged) {
    const auto sigma_after_n = [](Duration second) {
        InverseInterval decoder({}, fingertip());
        decoder.observe(at(0ms), at(41ms) + second,
                        std::vector<Event>{{at(20ms), 0}, {at(40ms), 0}, {at(40ms) + second, 0}});
        return decoder.estimate(at(41ms) + second).sigma_n;
    };
    const double held_n = sigma_after_n(20ms);
    EXPECT_GT(sigma_after_n(14ms), 3 * held_n) << "50 to 71 Hz";
    EXPECT_GT(sigma_after_n(10ms), 1.5 * sigma_after_n(14ms)) << "50 to 100 Hz";
}

TEST(InverseInterval, KnowsNoRateBeforeTheSecondSpike) {
    InverseInterval decoder({}, fingertip());
    decoder.observe(at(0ms), at(20ms), std::vector<Event>{{at(10ms), 0}});
    EXPECT_EQ(decoder.estimate(at(20ms)).rate_hz, 0);
}

TEST(InverseInterval, FallsWhileTheNextSpikeIsOverdueAndEndsInSilence) {
    InverseInterval decoder({}, fingertip());
    decoder.observe(at(0ms), at(100ms), regular_train(0, 0ms, 20ms, 100ms));
    const double steady_sigma_n = decoder.estimate(at(100ms)).sigma_n;
    decoder.observe(at(100ms), at(110ms), {});
    EXPECT_DOUBLE_EQ(decoder.estimate(at(110ms)).rate_hz, 1 / 0.030) << "30 ms after the last spike";
    decoder.observe(at(110ms), at(120ms), {});
    const Estimate overdue = decoder.estimate(at(120ms));
    EXPECT_DOUBLE_EQ(overdue.rate_hz, 25) << "40 ms after the last spike";
    EXPECT_GT(overdue.sigma_n, steady_sigma_n);
    decoder.observe(at(120ms), at(80ms) + decoder.history(), {});
    EXPECT_EQ(decoder.estimate(at(80ms) + decoder.history()).force_n, 0);
}

TEST(InverseInterval, DoesNotMeasureAcrossWhatIsLost) {
    InverseInterval decoder({}, fingertip());
    decoder.observe(at(0ms), at(100ms), regular_train(0, 0ms, 20ms, 100ms));
    decoder.lose(at(100ms), at(170ms));
    decoder.observe(at(170ms), at(180ms), std::vector<Event>{{at(175ms), 0}});
    EXPECT_DOUBLE_EQ(decoder.estimate(at(180ms)).rate_hz, 50) << "not 95 ms since the spike before the loss";
}

TEST(InverseInterval, ForgetsALossWithTheNextInterval) {
    InverseInterval decoder({}, fingertip());
    decoder.observe(at(0ms), at(100ms), regular_train(0, 0ms, 20ms, 100ms));
    decoder.lose(at(100ms), at(170ms));
    decoder.observe(at(170ms), at(270ms), regular_train(0, 180ms, 20ms, 250ms));
    EXPECT_DOUBLE_EQ(decoder.estimate(at(270ms)).rate_hz, 1 / 0.030) << "30 ms after the last spike";
}

TEST(InverseInterval, RefusesASnapshotOfOtherAddresses) {
    InverseInterval decoder({}, fingertip());
    InverseInterval::Snapshot snapshot = decoder.snapshot();
    snapshot.trains.resize(2);
    EXPECT_THROW(decoder.resume(snapshot), ParameterError);
}

}  // namespace
}  // namespace afferent
