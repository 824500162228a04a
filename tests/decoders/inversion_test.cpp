#include "afferent/decoders/inversion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "afferent/neurons/rate.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "tests/decoders/afferents.hpp"

namespace afferent {
namespace {

DecodedAfferents afferents_like(const NeuronModel& neuron, std::uint32_t afferents) {
    DecodedAfferents decoded{.addresses = afferents, .largest_grip_n = 50};
    for (Address address = 0; address < afferents; ++address)
        decoded.add(address, {neuron, 2, rheobase_mv(neuron) - 0.6}, 1.0 / afferents);
    return decoded;
}

LifParameters adapting() { return {.tau_g_ms = 500, .delta_g = 0.1}; }

TEST(Inversion, FindsAHeldForceFromItsFirstIntervalOnWhileTheNeuronAdapts) {
    for (const LifParameters& neuron :
         {adapting(), LifParameters{.delta_g = 0}, LifParameters{.delta_g = 2, .refractory_ms = 3}}) {
        const DecodedAfferents afferents = afferents_like(neuron, 1);
        const auto events = fired(afferents.groups[0], 1s, [](double) { return 12.0; });
        ASSERT_GT(events.size(), 5U);
        for (std::size_t i = 1; i < events.size(); ++i) {
            Inversion decoder({}, afferents);
            decoder.observe(at(0ms), events[i].time + 1ns, {events.data(), i + 1});
            // A stamp is rounded to half a nanosecond, and no interval is shorter than a millisecond.
            EXPECT_NEAR(decoder.estimate(events[i].time + 1ns).force_n, 12, 12 * 1e-6);
        }
    }
}

// Within a packet, from one to the next, and as the reciprocal of a rate cannot.
TEST(Inversion, FollowsARampWithTheDelayOfTheMembrane) {
    const DecodedAfferents afferents = afferents_like(adapting(), 1);
    const auto ramp_n = [](double time_s) { return 20 * time_s; };
    const auto events = fired(afferents.groups[0], 1s, ramp_n);
    ASSERT_GT(events.size(), 10U);
    Inversion decoder({}, afferents);
    decoder.observe(at(0ms), events.back().time + 1ns, events);
    const double now_s = seconds(events.back().time);
    const double late_s = now_s - decoder.estimate(events.back().time + 1ns).force_n / 20;
    EXPECT_GT(late_s, 0);
    EXPECT_LT(late_s, 0.010) << "tau_m";
}

TEST(Inversion, FallsWithSilence) {
    const DecodedAfferents afferents = afferents_like({}, 1);
    const auto events = fired(afferents.groups[0], 500ms, [](double) { return 10.0; });
    Inversion decoder({}, afferents);
    decoder.observe(at(0ms), at(500ms), events);
    double before_n = decoder.estimate(at(500ms)).force_n;
    EXPECT_NEAR(before_n, 10, 1e-3);
    for (Duration now = 510ms; now <= 700ms; now += 10ms) {
        decoder.observe(at(now - 10ms), at(now), {});
        const double force_n = decoder.estimate(at(now)).force_n;
        EXPECT_LE(force_n, before_n);
        before_n = force_n;
    }
    EXPECT_LT(before_n, 0.5);
    decoder.observe(at(700ms), at(3s), {});
    EXPECT_EQ(decoder.estimate(at(3s)).force_n, 0);
}

// From the bound B on: falling to B^2/F, it may just as well have stayed at B.
TEST(Inversion, IsAsUncertainWhileItFallsAsItMayHaveFallenTooFar) {
    const DecodedAfferents afferents = afferents_like({}, 1);
    const auto events = fired(afferents.groups[0], 500ms, [](double) { return 10.0; });
    Inversion decoder({}, afferents);
    decoder.observe(at(0ms), at(500ms), events);
    EXPECT_LT(decoder.estimate(at(500ms)).sigma_n, 1e-3);
    int falling = 0;
    for (Duration now = 505ms; now <= 600ms; now += 5ms) {
        decoder.observe(at(now - 5ms), at(now), {});
        const Estimate estimate = decoder.estimate(at(now));
        if (estimate.force_n > 9.99 || estimate.force_n == 0) continue;
        const double bound_n = std::sqrt(10 * estimate.force_n);
        // It divides by the part of the last 40 ms that is known: 1 - e^(-500/40) and more.
        EXPECT_NEAR(estimate.sigma_n, bound_n - estimate.force_n, 1e-4 * bound_n);
        ++falling;
    }
    EXPECT_GT(falling, 10);
}

TEST(Inversion, AfferentsThatFireTogetherAreNoSurerThanOne) {
    const DecodedAfferents one = afferents_like({}, 1);
    const DecodedAfferents nine = afferents_like({}, 9);
    const auto events = fired(one.groups[0], 300ms, [](double time_s) { return 10 + 20 * time_s; });
    std::vector<Event> together;
    for (const Event& event : events)
        for (Address address = 0; address < 9; ++address) together.push_back({event.time, address});
    Inversion of_one({}, one);
    Inversion of_nine({}, nine);
    of_one.observe(at(0ms), at(300ms), events);
    of_nine.observe(at(0ms), at(300ms), together);
    EXPECT_NEAR(of_nine.estimate(at(300ms)).force_n, of_one.estimate(at(300ms)).force_n, 1e-9);
    EXPECT_NEAR(of_nine.estimate(at(300ms)).sigma_n, of_one.estimate(at(300ms)).sigma_n, 1e-9);
}

// Two sensors at full scale, of 5 and of 8 N: the force may be the larger.
TEST(Inversion, IsAsUncertainAsTheFullScalesOfSaturatedSensorsDiffer) {
    DecodedAfferents two{.addresses = 2, .largest_grip_n = 50};
    for (Address address = 0; address < 2; ++address) {
        DecodedAfferents::Group group{LifParameters(), 2, rheobase_mv(LifParameters()) - 0.6};
        group.full_scale_n = address == 0 ? 5 : 8;
        two.add(address, group, 0.5);
    }
    ASSERT_EQ(two.groups.size(), 2U);
    auto events = fired(two.groups[0], 1s, [](double) { return 5.0; });
    const auto second = fired(
        two.groups[1], 1s, [](double) { return 8.0; }, 1);
    events.insert(events.end(), second.begin(), second.end());
    std::sort(events.begin(), events.end());
    Inversion decoder({}, two);
    decoder.observe(at(0ms), at(1s), events);
    const Estimate estimate = decoder.estimate(at(1s));
    EXPECT_EQ(estimate.doubt, Doubt::saturated);
    EXPECT_GE(estimate.force_n + 2 * estimate.sigma_n, 8 - 1e-9);
    EXPECT_LT(estimate.force_n + 2 * estimate.sigma_n, 10);
}

// Silence has told that the force is no longer one of full scale.
TEST(Inversion, IsSaturatedNoLongerOnceSilenceTellsLess) {
    DecodedAfferents one{.addresses = 1, .largest_grip_n = 50};
    DecodedAfferents::Group group{LifParameters(), 2, rheobase_mv(LifParameters()) - 0.6};
    group.full_scale_n = 8;
    one.add(0, group, 1);
    Inversion decoder({}, one);
    decoder.observe(at(0ms), at(1s), fired(group, 1s, [](double) { return 8.0; }));
    EXPECT_EQ(decoder.estimate(at(1s)).doubt, Doubt::saturated);
    decoder.observe(at(1s), at(1s + 60ms), {});
    const Estimate later = decoder.estimate(at(1s + 60ms));
    EXPECT_NE(later.doubt, Doubt::saturated);
    EXPECT_LT(later.force_n, 7);
}

TEST(Inversion, ADeadAfferentHasNextToNoWeight) {
    const DecodedAfferents two = afferents_like({}, 2);
    const auto events = fired(two.groups[0], 1s, [](double) { return 10.0; });
    Inversion decoder({}, two);
    decoder.observe(at(0ms), at(1s), events);
    EXPECT_NEAR(decoder.estimate(at(1s)).force_n, 10, 0.1);
}

TEST(Inversion, KeepsTheAdaptationThroughALoss) {
    const DecodedAfferents afferents = afferents_like(adapting(), 1);
    const auto events = fired(afferents.groups[0], 1s, [](double) { return 12.0; });
    Inversion decoder({}, afferents);
    const auto lost = std::lower_bound(events.begin(), events.end(), Event{at(700ms), 0});
    const auto heard = std::lower_bound(events.begin(), events.end(), Event{at(800ms), 0});
    decoder.observe(at(0ms), at(700ms), {events.begin(), lost});
    decoder.lose(at(700ms), at(800ms));
    decoder.observe(at(800ms), at(1s), {heard, events.end()});
    // Without the spikes that were lost, it would be off by Δg W/k for each of them: 1 N for one.
    EXPECT_NEAR(decoder.estimate(at(1s)).force_n, 12, 0.5);
}

TEST(Inversion, DoesNotCountSpikesOfALostSpan) {
    const DecodedAfferents afferents = afferents_like(adapting(), 1);
    const auto events = fired(afferents.groups[0], 1s, [](double) { return 12.0; });
    const auto heard = std::lower_bound(events.begin(), events.end(), Event{at(800ms), 0});
    std::vector<Event> late = {{at(790ms), 0}};
    late.insert(late.end(), heard, events.end());
    Inversion without({}, afferents);
    Inversion with({}, afferents);
    for (Inversion* const decoder : {&without, &with}) {
        decoder->observe(at(0ms), at(700ms),
                         {events.begin(), std::lower_bound(events.begin(), heard, Event{at(700ms), 0})});
        decoder->lose(at(700ms), at(800ms));
    }
    without.observe(at(800ms), at(1s), {heard, events.end()});
    with.observe(at(780ms), at(1s), late);
    EXPECT_EQ(with.estimate(at(1s)).force_n, without.estimate(at(1s)).force_n);
}

// The force before the silence is no longer expected after it.
TEST(Inversion, TakesNoWeakForceForAStrongOneBecauseAPacketWasLostInTheSilenceBefore) {
    const DecodedAfferents afferents = afferents_like(LifParameters{.tau_g_ms = 100, .delta_g = 0.03}, 1);
    const auto events =
        fired(afferents.groups[0], 1s, [](double time_s) { return time_s < 0.5 ? 20.0 : 1.0; });
    const auto weak = std::ranges::lower_bound(events, Event{at(510ms), 0});
    ASSERT_NE(weak, events.end());
    ASSERT_GT(weak->time, at(700ms));
    const TimePoint lost = weak->time - 150ms;
    Inversion decoder({}, afferents);
    decoder.observe(at(0ms), lost, {events.begin(), weak});
    decoder.lose(lost, lost + 40ms);
    decoder.observe(lost + 40ms, weak->time + 1ms, {weak, weak + 1});
    EXPECT_NEAR(decoder.estimate(weak->time + 1ms).force_n, 1, 0.1);
}

TEST(Inversion, RefusesASnapshotOfOtherAfferents) {
    Inversion decoder({}, afferents_like({}, 1));
    EXPECT_THROW(decoder.resume(Inversion({}, afferents_like({}, 2)).snapshot()), ParameterError);
}

}  // namespace
}  // namespace afferent
