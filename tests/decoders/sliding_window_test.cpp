#include "afferent/decoders/sliding_window.hpp"

#include <gtest/gtest.h>

#include "afferent/decoders/force_rate_curves.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "tests/decoders/afferents.hpp"

namespace afferent {
namespace {

// The same from its two parts, with curves put together by hand.
void expect_counts_inverted(Pooling pooling, RateKind curve, GripEstimator estimator) {
    const DecodedAfferents afferents = fingertips();
    SlidingWindow decoder({.window = 60ms, .curve = curve, .pooling = pooling}, afferents);
    SpikeRate rate({true, true, false, true, true}, 60ms);
    for (const Step& step : random_stream(1, 1000, afferents.addresses)) {
        if (step.lost)
            rate.lose(step.begin, step.end);
        else
            rate.observe(step.begin, step.end, step.events);
        rate.presume_silence(step.presumed);
        rate.advance(step.now);
        ASSERT_EQ(take(decoder, step), estimator(rate));
    }
}

TEST(SlidingWindow, InvertsThePooledCurveBitForBit) {
    for (const RateKind curve : {RateKind::steady, RateKind::onset})
        expect_counts_inverted(Pooling::pooled, curve, {pooled_curve(fingertips(), curve), {2, 1, 1}});
}

TEST(SlidingWindow, InvertsEachNeuronsCurveBitForBit) {
    for (const RateKind curve : {RateKind::steady, RateKind::onset})
        expect_counts_inverted(
            Pooling::per_neuron, curve,
            {{group_curve(group_with(2), curve, 20), group_curve(group_with(4), curve, 20)},
             {{0, 0, 0.25}, {1, 0, 0.25}, {3, 1, 0.5}}});
}

// Nine afferents that are alike fire together under a held force, as in recorded.txtpb.
TEST(SlidingWindow, CoversAHeldForceThatNineAlikeAfferentsFeel) {
    DecodedAfferents nine{.addresses = 9, .largest_grip_n = 20};
    for (Address address = 0; address < 9; ++address) nine.add(address, group_with(2), 1.0 / 9);
    SlidingWindow decoder({}, nine);
    int estimates = 0;
    int within = 0;
    for (double force_n = 2; force_n < 18; force_n += 0.37) {
        const Duration interval = rounded(Seconds(1 / nine.groups[0].rate_hz(RateKind::steady, force_n)));
        std::vector<Event> events;
        for (const Event& event : regular_train(0, 0ms, interval, 1s))
            for (Address address = 0; address < 9; ++address) events.push_back({event.time, address});
        for (Duration now = 200ms; now < 300ms; now += 1ms) {
            decoder.restart(scene_start);
            const auto end = std::lower_bound(events.begin(), events.end(), Event{at(now), 0});
            decoder.observe(scene_start, at(now), {events.begin(), end});
            const Estimate estimate = decoder.estimate(at(now));
            within += std::abs(estimate.force_n - force_n) <= 1.96 * estimate.sigma_n;
            ++estimates;
        }
    }
    // A count is off by less than one; sigma is sqrt(1/6) of one at the least.
    EXPECT_GE(within, 0.95 * estimates);
}

TEST(SlidingWindow, ContinuesAfterARestartAsItsPartsDo) {
    const DecodedAfferents afferents = fingertips();
    SlidingWindow decoder({}, afferents);
    SpikeRate rate(afferents.read(), 60ms);
    GripEstimator estimator = GripEstimator::of(afferents, RateKind::steady, Pooling::pooled);
    decoder.resume_after(at(20ms), at(15ms), {.force_n = 2});
    rate.resume(at(20ms), at(15ms));
    estimator.resume({.force_n = 2});
    for (const Step& step : random_stream(2, 50, afferents.addresses)) {
        if (step.begin < at(15ms) || step.lost) continue;
        rate.observe(step.begin, step.end, step.events);
        rate.presume_silence(step.presumed);
        rate.advance(step.now);
        ASSERT_EQ(take(decoder, step), estimator(rate));
    }
}

TEST(SlidingWindow, DependsOnOneWindowOfThePastOrOnWhenAnAfferentIsAtRest) {
    EXPECT_EQ(SlidingWindow({.window = 80ms}, fingertips()).history(), at_rest_after);
    EXPECT_EQ(SlidingWindow({.window = 1200ms}, fingertips()).history(), 1200ms);
}

TEST(SlidingWindow, MakesRoomForABusierWindowOnceAndKeepsIt) {
    const DecodedAfferents afferents = fingertips();
    SlidingWindow decoder({}, afferents);
    const std::size_t before = decoder.bytes();
    // 100 kHz from one address: 6000 events in the window, where there is room for 1024.
    decoder.observe(at(0ms), at(60ms), regular_train(0, 0ms, 10us, 60ms));
    const std::size_t busy = decoder.bytes();
    EXPECT_EQ(busy - before, (8192 - 1024) * sizeof(Event));
    (void)decoder.estimate(at(60ms));
    decoder.observe(at(60ms), at(120ms), regular_train(0, 60ms, 10us, 120ms));
    (void)decoder.estimate(at(120ms));
    EXPECT_LE(decoder.bytes(), before + (16384 - 1024) * sizeof(Event))
        << "two windows at most, as the estimate moves the window";
}

TEST(SlidingWindow, RefusesAWindowWithoutLengthAndASnapshotOfOtherAddresses) {
    EXPECT_THROW(SlidingWindow({.window = 0ns}, fingertips()), ParameterError);
    SlidingWindow decoder({}, fingertips());
    SlidingWindow::Snapshot snapshot = decoder.snapshot();
    SlidingWindow::Snapshot shorter = snapshot;
    shorter.rate.last_of.pop_back();
    EXPECT_THROW(decoder.resume(shorter), ParameterError);
    for (const Address address : {2U, 5U}) {
        snapshot.rate.events = {{at(0ms), address}};
        EXPECT_THROW(decoder.resume(snapshot), ParameterError);
    }
}

// At the reciprocal of a whole part of the window, whatever its last digit is.
TEST(SlidingWindow, HoldsAtLeastTheWholeSpikesOfARegularTrain) {
    const SlidingWindowParameters parameters{.window = 70ms};
    for (int spikes = 1; spikes < 300; ++spikes)
        EXPECT_NEAR(parameters.trough_hz(spikes / 0.07), spikes / 0.07, 1e-9 * spikes / 0.07) << spikes;
    EXPECT_NEAR(parameters.trough_hz(3.9 / 0.07), 3 / 0.07, 1e-9);
    EXPECT_EQ(parameters.trough_hz(0.9 / 0.07), 0);
}

}  // namespace
}  // namespace afferent
