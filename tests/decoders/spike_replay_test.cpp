#include "afferent/decoders/spike_replay.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "afferent/runtime/parameter_error.hpp"
#include "tests/decoders/afferents.hpp"

namespace afferent {
namespace {

const LifParameters adapting_neuron{.tau_g_ms = 500, .delta_g = 0.03};

DecodedAfferents one_afferent() {
    DecodedAfferents decoded{.addresses = 1, .largest_grip_n = 50};
    decoded.add(0, {adapting_neuron, 2, adapting_neuron.rheobase_mv() - 0.6}, 1);
    return decoded;
}

// Spikes of a force that is held.
std::vector<Event> held(const DecodedAfferents& decoded, double force_n) {
    return fired(
        decoded.groups[0], 1s, [&](double) { return force_n; }, 0);
}

// Hears the spikes up to `count`, but for those that `lost` leaves out; returns what the last one told.
SpikeReplay::Spike hear(SpikeReplay& replay, const std::vector<Event>& events, std::size_t count,
                        std::vector<std::size_t> lost, SpikeReplay::Expected expected) {
    SpikeReplay::Spike spike{};
    for (std::size_t i = 0; i < count; ++i) {
        if (std::find(lost.begin(), lost.end(), i) != lost.end()) {
            replay.lose(events[i].time - 1ms, events[i].time + 1ms);
            continue;
        }
        spike = replay.hear(0, events[i].time, expected);
    }
    return spike;
}

TEST(SpikeReplay, AHeldForceIsToldByEachInterval) {
    const DecodedAfferents decoded = one_afferent();
    SpikeReplay replay(decoded);
    const auto events = held(decoded, 8);
    for (std::size_t i = 0; i < events.size(); ++i) {
        const SpikeReplay::Spike spike = replay.hear(0, events[i].time, {8, 1});
        EXPECT_EQ(spike.known, i > 0 || events.at(0).time > at(50ms));
        // The table's error.
        if (i > 0) {
            EXPECT_NEAR(spike.measured.force_n, 8, 2e-3);
        }
    }
}

// At the scene's beginning every afferent is at rest; who is heard from the middle on may have fired before.
TEST(SpikeReplay, DoubtsTheAdaptationFromBeforeAStartInTheMiddle) {
    SpikeReplay replay(one_afferent());
    EXPECT_EQ(replay.train(0).doubt_g, 0);
    EXPECT_EQ(replay.unknown_since_start_n(at(0ms)), 0);
    replay.restart(at(1s));
    const double after_one_spike = replay.train(0).doubt_g;
    EXPECT_GE(after_one_spike, 0.5 * 0.03) << "half a spike at least";
    EXPECT_LT(after_one_spike, 1);
    const double unknown_n = replay.unknown_since_start_n(at(1s));
    EXPECT_GT(unknown_n, 0);
    // It decays with the adaptation, over 500 ms.
    EXPECT_NEAR(replay.unknown_since_start_n(at(1500ms)), unknown_n / std::exp(1), 1e-9);
    replay.restart(at(0ms));
    EXPECT_EQ(replay.train(0).doubt_g, 0);
    EXPECT_EQ(replay.unknown_since_start_n(at(0ms)), 0);
}

TEST(SpikeReplay, RefusesAnAfferentThatIsSilentThroughoutItsRange) {
    DecodedAfferents decoded = one_afferent();
    // A bias of 0.6 mV less than the rheobase; 2 mV to a newton.
    const double bias_mv = adapting_neuron.rheobase_mv() - 0.6;
    const double threshold_n = (adapting_neuron.rheobase_mv() - bias_mv) / 2;
    decoded.largest_grip_n = threshold_n;
    EXPECT_THROW(SpikeReplay{decoded}, ParameterError);
    decoded.largest_grip_n = std::nextafter(threshold_n, 1);
    EXPECT_NO_THROW(SpikeReplay{decoded});
}

TEST(SpikeReplay, ReadsNoAfferentWithoutADrive) {
    DecodedAfferents decoded = one_afferent();
    decoded.addresses = 3;
    decoded.add(1, {adapting_neuron, 0, 0}, 0.5);
    decoded.add(2, decoded.groups[0], 0);
    EXPECT_EQ(SpikeReplay(decoded).afferents(), 1U);
}

// g pulls the membrane towards E_k; the force that makes up for it drives by g (v_th − E_k), at 2 mV to a
// newton.
TEST(SpikeReplay, KnowsTheForceThatAdaptationTakes) {
    const DecodedAfferents decoded = one_afferent();
    SpikeReplay replay(decoded);
    hear(replay, held(decoded, 8), 20, {}, {8, 1});
    const double g = replay.train(0).g;
    EXPECT_GT(g, 5 * adapting_neuron.delta_g);
    EXPECT_NEAR(replay.adaptation_n(0), g * (adapting_neuron.v_th_mv - adapting_neuron.e_k_mv) / 2, 1e-9);
}

TEST(SpikeReplay, ALossWithoutASpikeCostsNothing) {
    const DecodedAfferents decoded = one_afferent();
    const auto events = held(decoded, 8);
    SpikeReplay whole(decoded);
    SpikeReplay lossy(decoded);
    const auto all = hear(whole, events, 10, {}, {8, 0.1});
    for (std::size_t i = 0; i < 10; ++i) {
        if (i == 9) lossy.lose(events.at(8).time + 1ms, events.at(8).time + 3ms);
        const auto spike = lossy.hear(0, events[i].time, {8, 0.1});
        if (i == 9) {
            EXPECT_TRUE(spike.known);
            EXPECT_NEAR(spike.measured.force_n, all.measured.force_n, 1e-9);
        }
    }
    EXPECT_NEAR(lossy.train(0).g, whole.train(0).g, 1e-3 * whole.train(0).g);
}

// Δg is 4 % of g here, and would be off by that for half a second.
TEST(SpikeReplay, OneLostSpikeIsKnownByTheIntervalThatItLeaves) {
    const DecodedAfferents decoded = one_afferent();
    const auto events = held(decoded, 8);
    SpikeReplay whole(decoded);
    SpikeReplay lossy(decoded);
    hear(whole, events, 20, {}, {8, 0.01});
    const auto spike = hear(lossy, events, 20, {18}, {8, 0.01});
    EXPECT_TRUE(spike.known);
    EXPECT_NEAR(spike.measured.force_n, 8, 3 * std::sqrt(spike.measured.variance_n2));
    EXPECT_NEAR(lossy.train(0).g, whole.train(0).g, 0.1 * adapting_neuron.delta_g);
}

// Each in a span of its own.
TEST(SpikeReplay, TwoLostSpikesAreKnownByTheIntervalThatTheyLeave) {
    const DecodedAfferents decoded = one_afferent();
    const auto events = held(decoded, 8);
    SpikeReplay whole(decoded);
    SpikeReplay lossy(decoded);
    hear(whole, events, 20, {}, {8, 0.01});
    const auto spike = hear(lossy, events, 20, {17, 18}, {8, 0.01});
    EXPECT_TRUE(spike.known);
    EXPECT_NEAR(spike.measured.force_n, 8, 3 * std::sqrt(spike.measured.variance_n2));
    // Some doubt remains: a force may change without anybody expecting it.
    EXPECT_LT(spike.measured.variance_n2, 1);
    EXPECT_NEAR(lossy.train(0).g, whole.train(0).g, 0.3 * adapting_neuron.delta_g);
    EXPECT_GT(lossy.train(0).doubt_g, 0.01 * adapting_neuron.delta_g);
}

// No spike was in a span that lies within the refractory period before the next one.
TEST(SpikeReplay, ALossWithinTheRefractoryPeriodCostsNothing) {
    DecodedAfferents decoded = one_afferent();
    LifParameters refractory = adapting_neuron;
    refractory.refractory_ms = 4;
    decoded.groups[0].neuron = refractory;
    const auto events = held(decoded, 8);
    SpikeReplay replay(decoded);
    hear(replay, events, 10, {}, {8, 0.1});
    replay.lose(events.at(10).time - 3ms, events.at(10).time - 1ms);
    const auto spike = replay.hear(0, events.at(10).time, {8, 0.1});
    EXPECT_TRUE(spike.known);
    EXPECT_NEAR(spike.measured.force_n, 8, 2e-3);
    EXPECT_LT(spike.measured.variance_n2, 1e-3);
}

TEST(SpikeReplay, ManyLostSpikesTellNothingAndLeaveADoubt) {
    const DecodedAfferents decoded = one_afferent();
    const auto events = held(decoded, 8);
    SpikeReplay whole(decoded);
    SpikeReplay lossy(decoded);
    hear(whole, events, 20, {}, {8, 0.01});
    hear(lossy, events, 10, {}, {8, 0.01});
    lossy.lose(events.at(9).time + 1us, events.at(19).time);
    EXPECT_FALSE(lossy.hear(0, events.at(19).time, {8, 0.01}).known);
    const SpikeReplay::Train& train = lossy.train(0);
    EXPECT_GT(train.doubt_g, adapting_neuron.delta_g);
    EXPECT_NEAR(train.g, whole.train(0).g, 2 * train.doubt_g);
}

TEST(SpikeReplay, AForceThatIsKnownPutsADoubtfulAdaptationRight) {
    const DecodedAfferents decoded = one_afferent();
    const auto events = held(decoded, 8);
    SpikeReplay whole(decoded);
    hear(whole, events, 20, {}, {8, 0.01});
    SpikeReplay lossy(decoded);
    hear(lossy, events, 10, {}, {8, 0.01});
    lossy.lose(events.at(9).time + 1us, events.at(17).time);
    for (std::size_t i = 17; i < 20; ++i) {
        const auto spike = lossy.hear(0, events[i].time, {8, 1e-4});
        if (spike.known) lossy.correct(0, spike.measured, {8, 1e-4});
    }
    EXPECT_NEAR(lossy.train(0).g, whole.train(0).g, 0.3 * adapting_neuron.delta_g);
}

TEST(SpikeReplay, SilenceBoundsTheForceFromAbove) {
    const DecodedAfferents decoded = one_afferent();
    SpikeReplay replay(decoded);
    const auto events = held(decoded, 8);
    hear(replay, events, 10, {}, {8, 1});
    const TimePoint last = events.at(9).time;
    EXPECT_GT(replay.silent(0, last + 5ms).force_n, 8);
    EXPECT_NEAR(replay.silent(0, events.at(10).time).force_n, 8, 2e-3);
    EXPECT_LT(replay.silent(0, last + 100ms).force_n, 8);
    // What is lost right after it may have held a spike.
    replay.lose(last + 50ms, last + 90ms);
    EXPECT_GT(replay.silent(0, last + 95ms).force_n, 8);
}

TEST(SpikeReplay, JoinsLossesThatTouchAndKeepsTheLast) {
    SpikeReplay replay(one_afferent());
    const auto latest = [&] {
        const auto span = replay.snapshot().losses.spans[0];
        return std::pair(span.begin, span.end);
    };
    replay.lose(at(20ms), at(10ms));
    EXPECT_EQ(replay.snapshot().losses.count, 0U) << "no span";
    replay.lose(at(10ms), at(20ms));
    replay.lose(at(20ms), at(30ms));
    EXPECT_EQ(latest(), std::pair(at(10ms), at(30ms)));
    replay.lose(at(5ms), at(12ms));
    EXPECT_EQ(latest(), std::pair(at(5ms), at(30ms)));
    EXPECT_EQ(replay.snapshot().losses.count, 1U);
    for (int i = 4; i < 40; ++i) replay.lose(at(i * 10ms), at(i * 10ms + 5ms));
    EXPECT_EQ(latest(), std::pair(at(390ms), at(395ms)));
    EXPECT_EQ(replay.snapshot().losses.count, 32U);
    EXPECT_EQ(replay.snapshot().losses.spans[31].begin, at(80ms));
}

}  // namespace
}  // namespace afferent
