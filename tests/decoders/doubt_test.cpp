// What decoders say of an estimate that may be far below the force.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "afferent/decoders/decoders.hpp"
#include "afferent/decoders/grip_decoder.hpp"
#include "tests/decoders/afferents.hpp"

namespace afferent {
namespace {

constexpr Pooling poolings[]{Pooling::pooled, Pooling::per_neuron};

// One afferent that begins to fire at 0.3 N.
DecodedAfferents one_afferent() {
    DecodedAfferents decoded{.addresses = 1, .largest_grip_n = 50};
    decoded.add(0, group_with(2), 1);
    return decoded;
}

// The force at which the afferent fires with that interval.
double steady_force_n(const DecodedAfferents& decoded, Duration interval) {
    return decoded.groups.front().grip_n(RateKind::steady, 1 / seconds(interval));
}

double upper_n(const Estimate& estimate) { return estimate.force_n + 2 * estimate.sigma_n; }

// Curves are interpolated within 5e-5 of their curvature.
constexpr double interpolated = 1e-3;

template <class D>
void expect_slow_silence(const typename D::Parameters& parameters, Duration memory) {
    const DecodedAfferents decoded = one_afferent();
    D decoder(parameters, decoded);
    // 5 Hz: once in 200 ms.
    decoder.observe(scene_start, at(2s), regular_train(0, 0ms, 200ms, 2s));
    decoder.presume_silence(at(10s));
    const TimePoint last = at(1800ms);
    for (Duration silent = memory; silent < 1s; silent += 20ms) {
        const Estimate estimate = decoder.estimate(std::max(last + silent, at(2s)));
        const Duration since = std::max(last + silent, at(2s)) - last;
        const double allowed_n = steady_force_n(decoded, since);
        EXPECT_EQ(estimate.doubt, Doubt::slow) << seconds(since);
        EXPECT_GE(upper_n(estimate), (1 - interpolated) * allowed_n) << seconds(since);
    }
    // At rest.
    for (const Duration silent : {1s, 2s, 5s}) {
        const Estimate estimate = decoder.estimate(last + silent);
        EXPECT_EQ(estimate.doubt, Doubt::none) << seconds(silent);
        EXPECT_LE(estimate.force_n, 0.3 + 1e-9) << "the force at which it begins to fire, at most";
    }
}

TEST(Doubt, ASlowAfferentMayBeSilentUnderTheForceOfItsRate) {
    for (const Pooling pooling : poolings) {
        expect_slow_silence<SlidingWindow>({.pooling = pooling}, 60ms);
        expect_slow_silence<Exponential>({.pooling = pooling}, 57ms);
    }
}

TEST(Doubt, RaisesSigmaNoFurtherThanTheSilenceAllows) {
    const DecodedAfferents decoded = one_afferent();
    for (const Pooling pooling : poolings) {
        SlidingWindow decoder({.pooling = pooling}, decoded);
        decoder.observe(scene_start, at(0ms), {});
        decoder.observe(scene_start, at(70ms), std::vector<Event>{{at(0ms), 0}});
        const Estimate estimate = decoder.estimate(at(70ms));
        EXPECT_EQ(estimate.doubt, Doubt::slow);
        EXPECT_NEAR(upper_n(estimate), steady_force_n(decoded, 70ms), interpolated * upper_n(estimate));
    }
}

TEST(Doubt, OfALostSpanIsThatOfTheSilenceSince) {
    const DecodedAfferents decoded = one_afferent();
    SlidingWindow decoder({}, decoded);
    decoder.observe(scene_start, at(50ms), std::vector<Event>{{at(0ms), 0}});
    decoder.lose(at(50ms), at(150ms));
    decoder.observe(at(150ms), at(180ms), {});
    const Estimate estimate = decoder.estimate(at(180ms));
    EXPECT_EQ(estimate.doubt, Doubt::slow);
    EXPECT_NEAR(upper_n(estimate), steady_force_n(decoded, 30ms), interpolated * upper_n(estimate));
}

TEST(Doubt, IsNoneWhereNothingEverFired) {
    for (const Pooling pooling : poolings) {
        SlidingWindow window({.pooling = pooling}, one_afferent());
        Exponential exponential({.pooling = pooling}, one_afferent());
        InverseInterval interval({.pooling = pooling}, one_afferent());
        window.observe(scene_start, at(1s), {});
        exponential.observe(scene_start, at(1s), {});
        interval.observe(scene_start, at(1s), {});
        EXPECT_EQ(window.estimate(at(1s)).doubt, Doubt::none);
        EXPECT_EQ(exponential.estimate(at(1s)).doubt, Doubt::none);
        EXPECT_EQ(interval.estimate(at(1s)).doubt, Doubt::none);
    }
}

// A neuron that still tells the force outweighs three quarters that do not.
TEST(Doubt, SaturatedNeuronsCountAsThoseThatCanStillTell) {
    DecodedAfferents decoded = sensors(4, {0.5, 0.3, 0.2});
    // Full scale at 8, 13.3 and 20 N.
    const auto events = pressed(decoded, 2s, [](double) { return 12.0; });
    InverseInterval decoder({.pooling = Pooling::per_neuron}, decoded);
    const Estimate estimate = estimates(decoder, events, 2s).back();
    EXPECT_EQ(estimate.doubt, Doubt::none) << "half of the load is told";
    EXPECT_NEAR(estimate.force_n, 12, 0.02 * 12);
}

// Without a law of where a curve ends, the pooled curve would rise on.
TEST(Doubt, ThePooledCurveBendsWhereElementsAreAtFullScale) {
    const DecodedAfferents decoded = sensors(4, {0.5, 0.3, 0.2});
    const auto events = pressed(decoded, 2s, [](double) { return 12.0; });
    InverseInterval decoder({}, decoded);
    EXPECT_NEAR(estimates(decoder, events, 2s).back().force_n, 12, 0.02 * 12);
}

// Nine elements that grip, hold and let go; 10 % of packets lost, five draws of which.
TEST(Doubt, LossesAreNoLongerIntervals) {
    DecodedAfferents decoded = sensors(25, shares_of_nine());
    const auto force_n = [](double time_s) {
        if (time_s < 0.5) return 0.0;
        if (time_s < 0.8) return 8 * (time_s - 0.5) / 0.3;
        return time_s < 2.6 ? 8.0 : std::max(8 * (2.8 - time_s) / 0.2, 0.0);
    };
    const auto events = pressed(decoded, 4s, force_n);
    for (const Pooling pooling : poolings) {
        const auto squares = [&](auto is_lost) {
            InverseInterval decoder({.pooling = pooling}, decoded);
            double sum = 0;
            Duration now = 0ms;
            for (const Estimate& estimate : estimates(decoder, events, 4s, is_lost))
                sum += std::pow(estimate.force_n - force_n(seconds(now += 5ms)), 2);
            return sum;
        };
        const double lossless = squares([] { return false; });
        double lossy = 0;
        for (unsigned draw = 0; draw < 5; ++draw) {
            std::mt19937 random(draw);
            lossy += squares([&] { return random() % 10 == 0; }) / 5;
        }
        EXPECT_LT(lossy, 4 * lossless) << "twice the RMS";
    }
}

// An afferent of 50 Hz whose spike at 40 ms is lost: the interval is two.
TEST(Doubt, AnIntervalOverALossIsTakenForTwoWhereOneWouldBeTwiceAsLong) {
    const DecodedAfferents decoded = one_afferent();
    InverseInterval decoder({}, decoded);
    decoder.observe(scene_start, at(38ms), regular_train(0, 0ms, 20ms, 38ms));
    decoder.lose(at(38ms), at(43ms));
    decoder.observe(at(43ms), at(61ms), regular_train(0, 60ms, 20ms, 61ms));
    EXPECT_NEAR(decoder.estimate(at(61ms)).rate_hz, 50, 1e-9);
    // With nothing lost it is one.
    InverseInterval whole({}, decoded);
    whole.observe(scene_start, at(38ms), regular_train(0, 0ms, 20ms, 38ms));
    whole.observe(at(38ms), at(61ms), regular_train(0, 60ms, 20ms, 61ms));
    EXPECT_NEAR(whole.estimate(at(61ms)).rate_hz, 25, 1e-9);
    // And so is one with a loss in it that is as long as those before.
    InverseInterval held({}, decoded);
    held.observe(scene_start, at(45ms), regular_train(0, 0ms, 20ms, 45ms));
    held.lose(at(45ms), at(50ms));
    held.observe(at(50ms), at(61ms), regular_train(0, 60ms, 20ms, 61ms));
    EXPECT_NEAR(held.estimate(at(61ms)).rate_hz, 50, 1e-9);
}

}  // namespace
}  // namespace afferent
