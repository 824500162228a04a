#include "afferent/decoders/filter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "afferent/decoders/sliding_window.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "tests/decoders/afferents.hpp"

namespace afferent {
namespace {

// Neurons that adapt over half a second, as in grasp.txtpb; each feels its part of 2 mV/N, and just that.
DecodedAfferents fingers(const std::vector<double>& parts) {
    const LifParameters neuron{.tau_g_ms = 500, .delta_g = 0.03};
    DecodedAfferents decoded{
        .addresses = parts.size(), .largest_grip_n = 50, .uncertainty = Uncertainty::none()};
    for (Address address = 0; address < parts.size(); ++address)
        decoded.add(address, {neuron, 2 * parts[address], neuron.rheobase_mv() - 0.6}, 1.0 / 9);
    return decoded;
}

// Rests, grips to 8 N within 100 ms, holds and lets go.
double grasp_n(double time_s) {
    if (time_s < 0.5 || time_s > 2.1) return 0;
    if (time_s < 0.6) return 80 * (time_s - 0.5);
    return time_s < 2 ? 8 : 80 * (2.1 - time_s);
}

template <class Force>
std::vector<Event> all_fired(const DecodedAfferents& afferents, Duration end, Force force_n) {
    std::vector<Event> events;
    for (const auto& [address, group, share, patch] : afferents.afferents) {
        const auto own = fired(afferents.groups[group], end, force_n, address);
        events.insert(events.end(), own.begin(), own.end());
    }
    std::sort(events.begin(), events.end());
    return events;
}

struct Score {
    double rms_n;
    double covered;  // part of the forces within 1.96 sigma
    double largest_n;
};

// Packets of 5 ms, delivered at once. Those that `lost` names are lost.
template <class D, class Force, class Lost>
Score score(D& decoder, const std::vector<Event>& events, Duration end, Force force_n, Lost lost) {
    double squares = 0;
    int covered = 0;
    int estimates = 0;
    double largest_n = 0;
    auto next = events.begin();
    for (Duration begin = 0ms; begin < end; begin += 5ms) {
        const auto first = next;
        while (next != events.end() && next->time < at(begin + 5ms)) ++next;
        if (lost(begin / 5ms))
            decoder.lose(at(begin), at(begin + 5ms));
        else
            decoder.observe(at(begin), at(begin + 5ms), {first, next});
        for (Duration now = begin + 5ms; now < begin + 10ms; now += 1ms) {
            const Estimate estimate = decoder.estimate(at(now));
            const double error_n = estimate.force_n - force_n(seconds(now));
            squares += error_n * error_n;
            covered += std::abs(error_n) <= 1.96 * estimate.sigma_n;
            largest_n = std::max(largest_n, estimate.force_n);
            ++estimates;
        }
    }
    return {std::sqrt(squares / estimates), static_cast<double>(covered) / estimates, largest_n};
}

constexpr auto nothing = [](std::int64_t) { return false; };

TEST(Filter, FollowsAGraspFarBetterThanTheWindowAndCoversIt) {
    for (const auto& parts : {std::vector{1.0}, std::vector(9, 1.0), {1.8, 1.6, 1.1, 1.0, 0.9, 0.5}}) {
        const DecodedAfferents afferents = fingers(parts);
        const auto events = all_fired(afferents, 3s, grasp_n);
        Filter filter({}, afferents);
        SlidingWindow window({}, afferents);
        const Score of_filter = score(filter, events, 3s, grasp_n, nothing);
        const Score of_window = score(window, events, 3s, grasp_n, nothing);
        EXPECT_LT(of_filter.rms_n, of_window.rms_n / 3);
        EXPECT_GT(of_filter.covered, 0.9);
        EXPECT_LT(of_filter.largest_n, 8 + 1.5) << "overshoot";
    }
}

TEST(Filter, IsQuietAndRightInAHold) {
    const DecodedAfferents afferents = fingers({1.5, 1.0, 0.7});
    const auto events = all_fired(afferents, 3s, [](double) { return 7.0; });
    Filter decoder({}, afferents);
    decoder.observe(at(0ms), at(3s), events);
    const Estimate estimate = decoder.estimate(at(3s));
    EXPECT_NEAR(estimate.force_n, 7, 0.01 * 7);
    EXPECT_LT(estimate.sigma_n, 0.03 * 7);
}

// Little right after a contact, and nearly all of the force once it has been held for long.
TEST(Filter, TellsHowMuchAdaptationThatIsNotAsStatedMayChange) {
    const auto sigma_n = [](double uncertainty, Duration now) {
        DecodedAfferents afferents = fingers({1.2, 1, 0.8});
        afferents.uncertainty.adaptation = uncertainty;
        const auto events = all_fired(afferents, now, [](double s) { return s < 0.5 ? 0.0 : 8.0; });
        Filter decoder({}, afferents);
        decoder.observe(at(0ms), at(now), events);
        return decoder.estimate(at(now)).sigma_n;
    };
    const auto added_n = [&](Duration now) {
        return std::sqrt(std::pow(sigma_n(0.5, now), 2) - std::pow(sigma_n(0, now), 2));
    };
    EXPECT_LT(added_n(540ms), 0.5 * 3);
    EXPECT_NEAR(added_n(4s), 0.5 * 8, 0.5 * 0.5);
}

TEST(Filter, ForeseesAForceThatRisesAndNoneThatHoldsOrFalls) {
    const DecodedAfferents afferents = fingers({1.5, 1.2, 1.0, 0.8});
    const auto events = all_fired(afferents, 3s, grasp_n);
    FilterParameters parameters;
    parameters.lead = 50ms;
    Filter decoder(parameters, afferents);
    const auto coming = [&](Duration now) {
        decoder.restart(scene_start);
        decoder.observe(at(0ms), at(now),
                        {events.begin(), std::lower_bound(events.begin(), events.end(), Event{at(now), 0})});
        return decoder.estimate(at(now));
    };
    // At 80 N/s for the last 60 ms.
    const Estimate rising = coming(560ms);
    EXPECT_NEAR(rising.coming.value().force_n - rising.force_n, 80 * 0.05, 0.25 * 80 * 0.05);
    EXPECT_GT(rising.coming->sigma_n, rising.sigma_n);
    const Estimate held = coming(1900ms);
    EXPECT_NEAR(held.coming.value().force_n, held.force_n, 0.1);
    const Estimate falling = coming(2080ms);
    EXPECT_EQ(falling.coming.value().force_n, falling.force_n) << "never less than now";
    EXPECT_EQ(Filter({}, afferents).estimate(at(0ms)).coming, std::nullopt) << "nobody has asked";
}

// A force that is felt 40 ms later, by a decoder that is told of no, the true, and twice the delay.
TEST(Filter, AnswersForNowWhereItsSamplesAreLate) {
    const auto force_n = [](double time_s) {
        if (time_s < 0.5 || time_s > 2.2) return 0.0;
        if (time_s < 0.7) return 40 * (time_s - 0.5);
        return time_s < 2 ? 8.0 : 40 * (2.2 - time_s);
    };
    DecodedAfferents afferents = fingers({1.5, 1.2, 1.0, 0.8});
    const auto events = all_fired(afferents, 3s, [&](double time_s) { return force_n(time_s - 0.04); });
    const auto estimate = [&](Duration told, Duration now, Duration lead = 0ms) {
        afferents.delay = told;
        FilterParameters parameters;
        parameters.lead = lead;
        Filter decoder(parameters, afferents);
        decoder.observe(at(0ms), at(now),
                        {events.begin(), std::lower_bound(events.begin(), events.end(), Event{at(now), 0})});
        return decoder.estimate(at(now));
    };
    const auto error_n = [&](Duration told, Duration now) {
        return estimate(told, now).force_n - force_n(seconds(now));
    };
    // The force rises at 40 N/s.
    EXPECT_NEAR(error_n(0ms, 650ms), -1.6, 0.3) << "it is late";
    EXPECT_NEAR(error_n(40ms, 650ms), 0, 0.4);
    EXPECT_LT(std::abs(error_n(40ms, 650ms)), 2 * estimate(40ms, 650ms).sigma_n);
    EXPECT_NEAR(error_n(80ms, 650ms), 1.6, 0.6) << "too long is too high: the gain is too low";
    // It falls at 40 N/s.
    EXPECT_GT(error_n(0ms, 2120ms), 0.4);
    EXPECT_LT(error_n(80ms, 2120ms), error_n(40ms, 2120ms)) << "too long is too low";
    // It holds, and it rests.
    for (const Duration told : {40ms, 80ms}) {
        EXPECT_NEAR(error_n(told, 1900ms), 0, 0.1);
        EXPECT_GT(estimate(told, 1900ms).sigma_n, estimate(0ms, 1900ms).sigma_n);
        EXPECT_EQ(estimate(told, 300ms).force_n, 0);
    }
    EXPECT_NEAR(estimate(40ms, 650ms, 30ms).coming.value().force_n,
                estimate(0ms, 650ms, 70ms).coming.value().force_n, 1e-9);
    const Estimate falling = estimate(40ms, 2120ms, 30ms);
    EXPECT_EQ(falling.coming.value().force_n, falling.force_n) << "never less than now";
}

// A sample that is held for 20 ms is 10 ms old in the mean: at 20 N/s it would cost 0.2 N.
TEST(Filter, KnowsThatASampleIsHeld) {
    const auto ramp_n = [](double time_s) { return 20 * std::max(time_s - 0.2, 0.0); };
    const auto error_n = [&](Duration scan) {
        DecodedAfferents afferents = fingers({1.5, 1.2, 1.0, 0.8});
        afferents.scan = scan;
        const double scan_s = seconds(scan);
        const auto events = all_fired(afferents, 1s, [&](double time_s) {
            return ramp_n(scan_s > 0 ? std::floor(time_s / scan_s + 1e-9) * scan_s : time_s);
        });
        Filter decoder({}, afferents);
        double sum_n = 0;
        auto next = events.begin();
        for (Duration begin = 0ms; begin < 1s; begin += 5ms) {
            const auto first = next;
            while (next != events.end() && next->time < at(begin + 5ms)) ++next;
            decoder.observe(at(begin), at(begin + 5ms), {first, next});
            if (begin < 600ms) continue;
            sum_n += decoder.estimate(at(begin + 5ms)).force_n - ramp_n(seconds(begin + 5ms));
        }
        return sum_n / 80;
    };
    EXPECT_NEAR(error_n(20ms), error_n(0ms), 0.04);
}

TEST(Filter, AnEstimateDoesNotDependOnWhenItWasAskedBefore) {
    const DecodedAfferents afferents = fingers({1.5, 1.0, 0.7});
    const auto events = all_fired(afferents, 1s, grasp_n);
    Filter often({}, afferents);
    Filter once({}, afferents);
    auto next = events.begin();
    for (Duration begin = 0ms; begin < 1s; begin += 5ms) {
        const auto first = next;
        while (next != events.end() && next->time < at(begin + 5ms)) ++next;
        for (Filter* decoder : {&often, &once}) decoder->observe(at(begin), at(begin + 5ms), {first, next});
        for (Duration now = begin + 5ms; now < begin + 40ms; now += 1ms) {
            const Estimate estimate = often.estimate(at(now));
            if (now == begin + 29ms) {
                EXPECT_EQ(once.estimate(at(now)), estimate) << now.count();
            }
        }
    }
}

TEST(Filter, NineThatFireTogetherKnowNoMoreThanOne) {
    const DecodedAfferents one = fingers({1});
    const DecodedAfferents nine = fingers(std::vector(9, 1.0));
    Filter of_one({}, one);
    Filter of_nine({}, nine);
    of_one.observe(at(0ms), at(1500ms), all_fired(one, 1500ms, grasp_n));
    of_nine.observe(at(0ms), at(1500ms), all_fired(nine, 1500ms, grasp_n));
    const Estimate by_one = of_one.estimate(at(1500ms));
    const Estimate by_nine = of_nine.estimate(at(1500ms));
    // Their silences are taken a little differently: half of nine have to agree on a bound.
    EXPECT_NEAR(by_nine.force_n, by_one.force_n, 0.01 * by_one.sigma_n);
    EXPECT_NEAR(by_nine.sigma_n, by_one.sigma_n, 0.1 * by_one.sigma_n);
}

TEST(Filter, SilenceEndsAGrip) {
    const DecodedAfferents afferents = fingers({1.2, 1.0, 0.8});
    const auto let_go_n = [](double time_s) { return time_s < 1 ? 8.0 : 0.0; };
    Filter decoder({}, afferents);
    decoder.observe(at(0ms), at(1s), all_fired(afferents, 1s, let_go_n));
    EXPECT_NEAR(decoder.estimate(at(1s)).force_n, 8, 0.2);
    decoder.observe(at(1s), at(1500ms), {});
    const Estimate later = decoder.estimate(at(1500ms));
    EXPECT_LT(later.force_n, 4);
    EXPECT_LT(std::abs(later.force_n), 1.96 * later.sigma_n) << "nobody can tell yet that it is 0";
    decoder.observe(at(1500ms), at(4s), {});
    EXPECT_EQ(decoder.estimate(at(4s)).force_n, 0);
}

TEST(Filter, WhatIsLostWidensTheBeliefAndDoesNotMoveIt) {
    const DecodedAfferents afferents = fingers({1.2, 1.0, 0.8});
    const auto events = all_fired(afferents, 2s, [](double) { return 7.0; });
    const auto middle = std::lower_bound(events.begin(), events.end(), Event{at(1500ms), 0});
    Filter decoder({}, afferents);
    decoder.observe(at(0ms), at(1500ms), {events.begin(), middle});
    double sigma_n = decoder.estimate(at(1500ms)).sigma_n;
    for (Duration end = 1520ms; end <= 1600ms; end += 20ms) {
        decoder.lose(at(end - 20ms), at(end));
        const Estimate estimate = decoder.estimate(at(end));
        EXPECT_GT(estimate.sigma_n, sigma_n);
        EXPECT_NEAR(estimate.force_n, 7, 0.1 + 0.2 * estimate.sigma_n);
        sigma_n = estimate.sigma_n;
    }
}

TEST(Filter, LosesLittleWithOnePacketInTenAndKeepsItsCoverage) {
    const DecodedAfferents afferents = fingers({1.8, 1.6, 1.1, 1.0, 0.9, 0.5});
    const auto events = all_fired(afferents, 3s, grasp_n);
    Filter whole({}, afferents);
    Filter lossy({}, afferents);
    const Score of_whole = score(whole, events, 3s, grasp_n, nothing);
    const Score of_lossy = score(lossy, events, 3s, grasp_n, [](std::int64_t k) { return k % 10 == 7; });
    EXPECT_LT(of_lossy.rms_n, 2 * of_whole.rms_n);
    EXPECT_GT(of_lossy.covered, 0.9);
}

TEST(Filter, LeavesOutAfferentsThatAreDead) {
    const DecodedAfferents afferents = fingers({1.2, 1.0, 0.8});
    auto events = all_fired(afferents, 2s, [](double) { return 7.0; });
    std::erase_if(events, [](const Event& event) { return event.address == 1; });
    Filter decoder({}, afferents);
    decoder.observe(at(0ms), at(2s), events);
    EXPECT_NEAR(decoder.estimate(at(2s)).force_n, 7, 0.01 * 7);
    EXPECT_EQ(decoder.estimate(at(2s)).left_out, 1);
    EXPECT_TRUE(decoder.left_out(1));
    EXPECT_FALSE(decoder.left_out(0));
}

// Six fingers, of which one does not do what it should; the others are worth as much as without it.
class WithOneBadAfferent : public testing::Test {
  protected:
    void SetUp() override {
        events = all_fired(afferents, 3s, grasp_n);
        std::erase_if(events, [](const Event& event) { return event.address == bad; });
    }
    Score with(std::vector<Event> of_bad) {
        of_bad.insert(of_bad.end(), events.begin(), events.end());
        std::sort(of_bad.begin(), of_bad.end());
        return score(decoder, of_bad, 3s, grasp_n, nothing);
    }
    double rms_without_n() {
        DecodedAfferents good = fingers(parts);
        good.afferents.erase(good.afferents.begin() + bad);
        Filter other({}, good);
        return score(other, events, 3s, grasp_n, nothing).rms_n;
    }

    static constexpr Address bad = 2;
    const std::vector<double> parts{1.8, 1.6, 1.1, 1.0, 0.9, 0.5};
    const DecodedAfferents afferents = fingers(parts);
    std::vector<Event> events;
    Filter decoder{{}, afferents};
};

TEST_F(WithOneBadAfferent, ASilentOneIsLeftOut) { EXPECT_LT(with({}).rms_n, 1.5 * rms_without_n()); }

TEST_F(WithOneBadAfferent, AStuckOneIsLeftOut) {
    std::vector<Event> stuck;
    for (Duration time = 0ms; time < 3s; time += 23ms) stuck.push_back({at(time), bad});
    EXPECT_LT(with(stuck).rms_n, 2 * rms_without_n() + 0.05);
    EXPECT_TRUE(decoder.left_out(bad));
    EXPECT_EQ(decoder.estimate(at(3s)).left_out, 1);
}

TEST_F(WithOneBadAfferent, AWildOneIsLeftOut) {
    std::vector<Event> wild;
    std::mt19937 random(1);
    std::exponential_distribution<double> wait_s(80);
    for (double time_s = wait_s(random); time_s < 3; time_s += wait_s(random))
        wild.push_back({at(rounded(Seconds(time_s))), bad});
    EXPECT_LT(with(wild).rms_n, 2 * rms_without_n() + 0.05);
    EXPECT_TRUE(decoder.left_out(bad));
}

TEST_F(WithOneBadAfferent, OneThatRecoversCountsAgain) {
    const auto stuck_n = [](double time_s) { return time_s < 1 ? 20 : grasp_n(time_s); };
    std::vector<Event> recovers = fired(afferents.groups[bad], 3s, stuck_n, bad);
    recovers.insert(recovers.end(), events.begin(), events.end());
    std::sort(recovers.begin(), recovers.end());
    const auto until = [&](Duration time) {
        return std::lower_bound(recovers.begin(), recovers.end(), Event{at(time), 0});
    };
    decoder.observe(at(0ms), at(1s), {recovers.begin(), until(1s)});
    EXPECT_TRUE(decoder.left_out(bad));
    decoder.observe(at(1s), at(1900ms), {until(1s), until(1900ms)});
    EXPECT_FALSE(decoder.left_out(bad));
}

// A contradiction adds three to a score of at most 30, of which each spike that agrees takes one; below 6 the
// afferent counts again.
TEST_F(WithOneBadAfferent, OneThatWasWrongForLongAgreesTwentyFiveTimesBeforeItCountsAgain) {
    const auto stuck_n = [](double time_s) { return time_s < 1 ? 20 : grasp_n(time_s); };
    std::vector<Event> recovers = fired(afferents.groups[bad], 3s, stuck_n, bad);
    recovers.insert(recovers.end(), events.begin(), events.end());
    std::sort(recovers.begin(), recovers.end());
    int agreed = 0;
    for (const Event& event : recovers) {
        decoder.observe(decoder.heard_until(), event.time + 1ns, std::span(&event, 1));
        if (event.time < at(1s)) continue;
        agreed += event.address == bad;
        if (!decoder.left_out(bad)) break;
    }
    EXPECT_FALSE(decoder.left_out(bad));
    EXPECT_GE(agreed, 25);
}

TEST_F(WithOneBadAfferent, OneThatIsRejectedIsHeardAgainEveryMinute) {
    std::vector<Event> stuck = fired(
        afferents.groups[bad], 2s, [](double) { return 20.0; }, bad);
    stuck.insert(stuck.end(), events.begin(), events.end());
    std::erase_if(stuck, [](const Event& event) { return event.time >= at(2s); });
    std::sort(stuck.begin(), stuck.end());
    decoder.observe(at(0ms), at(2s), stuck);
    ASSERT_TRUE(decoder.left_out(bad));
    decoder.observe(at(2s), at(59'990ms), {});
    decoder.observe(at(59'990ms), at(59'999ms), {});
    EXPECT_TRUE(decoder.left_out(bad));
    decoder.observe(at(59'999ms), at(60'005ms), {});
    decoder.observe(at(60'005ms), at(60'010ms), {});
    EXPECT_FALSE(decoder.left_out(bad));
}

// One of two afferents cannot be outvoted by the other. If it claims a far higher force than the belief, that
// is noted all the same.
TEST(Filter, NotesAnObjectionWhereThereAreTwoAfferents) {
    const DecodedAfferents afferents = fingers({1.2, 1.0});
    const auto contradicted = [&](double second_n) {
        auto events = fired(afferents.groups[0], 3s, [](double) { return 7.0; });
        const auto second = fired(
            afferents.groups[1], 3s, [&](double) { return second_n; }, 1);
        events.insert(events.end(), second.begin(), second.end());
        std::sort(events.begin(), events.end());
        Filter decoder({}, afferents);
        return std::ranges::count(estimates(decoder, events, 3s), Doubt::contradicted, &Estimate::doubt);
    };
    EXPECT_EQ(contradicted(7), 0);
    EXPECT_GT(contradicted(20), 0);
}

TEST(Filter, OfTwoAfferentsOneThatDiesIsLeftOut) {
    const DecodedAfferents afferents = fingers({1.2, 1.0});
    auto events = all_fired(afferents, 3s, [](double) { return 7.0; });
    std::erase_if(events, [](const Event& event) { return event.address == 1 && event.time > at(1s); });
    Filter decoder({}, afferents);
    decoder.observe(at(0ms), at(3s), events);
    EXPECT_TRUE(decoder.left_out(1));
    EXPECT_FALSE(decoder.left_out(0));
    EXPECT_NEAR(decoder.estimate(at(3s)).force_n, 7, 0.05 * 7);
}

// One that is rejected is taken for faulty; two may be right.
TEST(Filter, IsDoubtedWhileSeveralThatAreRejectedFire) {
    const DecodedAfferents afferents = fingers({1.8, 1.6, 1.1, 1.0, 0.9, 0.5});
    const auto doubt = [&](Address stuck) {
        auto events = all_fired(afferents, 3s, [](double) { return 7.0; });
        std::erase_if(events, [&](const Event& event) { return event.address < stuck; });
        for (Address address = 0; address < stuck; ++address)
            for (Duration time = 0ms; time < 3s; time += 150ms) events.push_back({at(time), address});
        std::sort(events.begin(), events.end());
        Filter decoder({}, afferents);
        decoder.observe(at(0ms), at(3s), events);
        EXPECT_EQ(decoder.estimate(at(3s)).left_out, stuck);
        return decoder.estimate(at(3s)).doubt;
    };
    EXPECT_EQ(doubt(1), Doubt::none);
    EXPECT_EQ(doubt(2), Doubt::contradicted);
}

// The departure of a single element says nothing of how far they differ.
TEST(Filter, OfTwoAfferentsWithUncertainGainsTheOneThatIsLeftIsNotDoubted) {
    DecodedAfferents afferents = fingers({1.2, 1.0});
    afferents.uncertainty.gain = 0.2;
    auto events = all_fired(afferents, 3s, [](double) { return 7.0; });
    std::erase_if(events, [](const Event& event) { return event.address == 1 && event.time > at(1s); });
    Filter decoder({}, afferents);
    decoder.observe(at(0ms), at(3s), events);
    EXPECT_TRUE(decoder.left_out(1));
    EXPECT_LT(decoder.estimate(at(3s)).sigma_n, 0.5 * 7);
}

// One is stuck and rejected. Of the other two, which feel 8 N and fire every 12 to 19 ms, one falls silent
// for good, and at a second the other as well. Ten silences 10 ms apart make an afferent dead, but only those
// of a time in which another measures: when nothing is measured, the force itself may have gone.
TEST(Filter, SilenceIsHeldAgainstAnAfferentOnlyWhileOthersMeasure) {
    const DecodedAfferents afferents = fingers({1.2, 1.0, 0.8});
    const auto touched = [](double time_s) { return time_s < 0.5 ? 0 : 8; };
    const auto is_dead_that_is_silent_from = [&](Duration silent) {
        std::vector<Event> events =
            fired(afferents.groups[0], 2s, [](double time_s) { return time_s < 0.4 ? 0 : 12; });
        for (const auto& [address, ends] : {std::pair{1U, Duration(1s)}, {2U, silent}}) {
            const auto own = fired(afferents.groups[address], ends, touched, address);
            events.insert(events.end(), own.begin(), own.end());
        }
        std::sort(events.begin(), events.end());
        Filter decoder({}, afferents);
        score(decoder, events, 2s, touched, nothing);
        EXPECT_TRUE(decoder.left_out(0));
        EXPECT_FALSE(decoder.left_out(1));
        EXPECT_NEAR(decoder.estimate(at(2s)).force_n, 0, 0.01);
        return decoder.left_out(2);
    };
    EXPECT_FALSE(is_dead_that_is_silent_from(900ms));
    EXPECT_TRUE(is_dead_that_is_silent_from(850ms));
}

// Its sensor feels nothing for long enough to be taken for dead, as with a loose contact, and then feels
// again.
TEST(Filter, ListensAgainToAnAfferentThatWasDead) {
    const DecodedAfferents afferents = fingers({1.2, 1.0, 0.8});
    const auto touched = [](double time_s) { return time_s < 0.5 ? 0 : 8; };
    const auto loose = [&](double s) { return s > 0.85 && s < 1.5 ? 0 : touched(s); };
    std::vector<Event> events = fired(afferents.groups[2], 2s, loose, 2);
    for (const Address address : {0U, 1U}) {
        const auto own = fired(afferents.groups[address], 2s, touched, address);
        events.insert(events.end(), own.begin(), own.end());
    }
    std::sort(events.begin(), events.end());
    Filter decoder({}, afferents);
    const auto split = std::ranges::find_if(events, [](const Event& e) { return e.time >= at(1500ms); });
    decoder.observe(at(0ms), at(1500ms), {events.begin(), split});
    EXPECT_TRUE(decoder.left_out(2));
    decoder.observe(at(1500ms), at(2s), {split, events.end()});
    EXPECT_FALSE(decoder.left_out(2));
    EXPECT_NEAR(decoder.estimate(at(2s)).force_n, 8, 0.2);
}

// Under 8 N these fire every 12 ms or more often. Silence is taken in every 10 ms, so that 35 ms of it have
// told three times.
TEST(Filter, SilenceTellsEveryTenMilliseconds) {
    const DecodedAfferents afferents = fingers({1.2, 1.0, 0.8});
    const auto events = all_fired(afferents, 1s, [](double) { return 8.0; });
    ASSERT_FALSE(events.empty());
    const TimePoint last = events.back().time;
    Filter decoder({}, afferents);
    decoder.observe(at(0ms), last + 1ns, events);
    decoder.observe(last + 1ns, last + 10ms, {});
    EXPECT_NEAR(decoder.estimate(last + 10ms).force_n, 8, 0.1) << "as long as an interval";
    decoder.observe(last + 10ms, last + 35ms, {});
    EXPECT_LT(decoder.estimate(last + 35ms).force_n, 7.5);
}

// The afferents fire last at 0.997 s, and should fire again some 12 ms later.
TEST(Filter, EstimatesTakeTheSilenceSinceTheLastTenMillisecondsToo) {
    const DecodedAfferents afferents = fingers({1.2, 1.0, 0.8});
    Filter decoder({}, afferents);
    decoder.observe(at(0ms), at(1s), all_fired(afferents, 1s, [](double) { return 8.0; }));
    decoder.observe(at(1s), at(1011ms), {});
    const double expected_n = decoder.estimate(at(1011ms)).sigma_n;
    decoder.observe(at(1011ms), at(1019ms), {});
    EXPECT_GT(decoder.estimate(at(1019ms)).sigma_n, 4 * expected_n);
}

TEST(Filter, AnElementAtItsFullScaleIsOutdoneByOthersThatAreNot) {
    DecodedAfferents afferents = fingers({1.2, 1.0, 0.8});
    afferents.groups[0].full_scale_n = 5;
    std::vector<Event> events = all_fired(afferents, 2s, [](double) { return 8.0; });
    std::erase_if(events, [](const Event& event) { return event.address == 0; });
    const auto saturated = fired(
        afferents.groups[0], 2s, [](double) { return 5.0; }, 0);
    events.insert(events.end(), saturated.begin(), saturated.end());
    std::sort(events.begin(), events.end());
    Filter decoder({}, afferents);
    decoder.observe(at(0ms), at(2s), events);
    EXPECT_NEAR(decoder.estimate(at(2s)).force_n, 8, 0.01 * 8);
}

// Of the slope of the grasp, as transient encoders tell it.
TEST(Filter, TransientAfferentsMakeItFollowMotionMoreClosely) {
    const DecodedAfferents sustained = fingers({1.0, 0.5});
    DecodedAfferents both = sustained;
    const LifParameters neuron{.tau_g_ms = 500, .delta_g = 0.03};
    both.addresses = 3;
    both.add(2, {neuron, 0, neuron.rheobase_mv() - 0.6, 0.1}, 1.0 / 9);
    const auto speed_n_per_s = [](double time_s) {
        return std::abs(grasp_n(time_s + 1e-4) - grasp_n(time_s - 1e-4)) / 2e-4;
    };
    auto events = all_fired(sustained, 3s, grasp_n);
    Filter without({}, sustained);
    const Score of_one = score(without, events, 3s, grasp_n, nothing);
    DecodedAfferents::Group as_force = both.groups.back();
    as_force.drive_mv_per_n = as_force.drive_mv_s_per_n;
    const auto transient = fired(as_force, 3s, speed_n_per_s, 2);
    ASSERT_GT(transient.size(), 5);
    events.insert(events.end(), transient.begin(), transient.end());
    std::sort(events.begin(), events.end());
    Filter with({}, both);
    const Score of_both = score(with, events, 3s, grasp_n, nothing);
    EXPECT_LT(of_both.rms_n, 0.9 * of_one.rms_n);
}

TEST(Filter, KnowsWhichWayHysteresisReads) {
    DecodedAfferents afferents = fingers({1.2, 1.0, 0.8});
    afferents.hysteresis = 0.05;
    // Loaded, then unloaded by more than the play.
    const auto sensed_n = [](double time_s) { return time_s < 1 ? 0.95 * 8 : 1.05 * 6; };
    const auto events = all_fired(afferents, 2s, sensed_n);
    const auto middle = std::lower_bound(events.begin(), events.end(), Event{at(1s), 0});
    Filter decoder({}, afferents);
    decoder.observe(at(0ms), at(1s), {events.begin(), middle});
    EXPECT_NEAR(decoder.estimate(at(1s)).force_n, 8, 0.1);
    decoder.observe(at(1s), at(2s), {middle, events.end()});
    EXPECT_NEAR(decoder.estimate(at(2s)).force_n, 6, 0.1);
}

TEST(Filter, SensorsAtFullScaleGiveALowerBoundThatSaysSo) {
    DecodedAfferents afferents = fingers({1.2, 1.0, 0.8});
    for (auto& group : afferents.groups) group.full_scale_n = 5;
    const auto sensed_n = [](double time_s) { return time_s < 2 ? std::min(5.0, 20 * time_s) : 3.0; };
    const auto events = all_fired(afferents, 3s, sensed_n);
    Filter decoder({}, afferents);
    auto next = events.begin();
    for (Duration begin = 0ms; begin < 3s; begin += 5ms) {
        const auto first = next;
        while (next != events.end() && next->time < at(begin + 5ms)) ++next;
        decoder.observe(at(begin), at(begin + 5ms), {first, next});
        const Estimate estimate = decoder.estimate(at(begin + 5ms));
        if (begin > 500ms && begin < 2s) {
            ASSERT_EQ(estimate.doubt, Doubt::saturated) << begin.count();
            // Noise and steps may make a sensor read full scale 2 % early.
            ASSERT_GE(estimate.force_n, 0.98 * 5);
            // The force may be anything above: half as much again is within two sigma.
            ASSERT_GE(estimate.sigma_n, estimate.force_n / 2);
            ASSERT_LE(estimate.sigma_n, 0.75 * estimate.force_n);
        }
        if (begin > 2500ms) {
            ASSERT_EQ(estimate.doubt, Doubt::none) << begin.count();
        }
    }
    EXPECT_NEAR(decoder.estimate(at(3s)).force_n, 3, 0.1);
}

// While it is being loaded, such a sensor reads less than its full scale for good.
TEST(Filter, SensorsAtFullScaleThatReadLowByHysteresisGiveALowerBound) {
    constexpr double hysteresis = 0.03;
    DecodedAfferents afferents = sensors(1.6, {0.22, 0.37, 0.41});
    DecodedAfferents read_low = afferents;
    for (auto& group : read_low.groups) group.full_scale_n *= 1 - hysteresis;
    const auto events =
        pressed(read_low, 3s, [](double time_s) { return (1 - hysteresis) * std::min(18.0, 12 * time_s); });
    afferents.hysteresis = hysteresis;
    Filter decoder({}, afferents);
    const std::vector<Estimate> all = estimates(decoder, events, 3s);
    // From one second on the force is beyond every sensor's range.
    for (std::size_t i = 200; i < all.size(); ++i) {
        ASSERT_EQ(all[i].doubt, Doubt::saturated) << 5 * i << " ms";
        ASSERT_GE(all[i].force_n, 0.95 * afferents.largest_grip_n) << 5 * i << " ms";
    }
}

// What afferents fire whose gains are so many times those that the decoder is told.
std::vector<Event> fired_with(const DecodedAfferents& told, const std::vector<double>& gains) {
    DecodedAfferents truth = told;
    truth.groups.clear();
    truth.afferents.clear();
    for (Address address = 0; address < gains.size(); ++address) {
        DecodedAfferents::Group group = told.groups[0];
        group.drive_mv_per_n *= gains[address];
        truth.add(address, group, 1.0 / 9);
    }
    return all_fired(truth, 3s, [](double) { return 8.0; });
}

// Three fingers of three; their gains are off by up to 15 %, by 8 % in the mean square.
TEST(Filter, GainsThatAreNotAsStatedAreLearnedAndNobodyIsLeftOut) {
    DecodedAfferents told = fingers(std::vector(9, 1.0));
    told.uncertainty = Uncertainty();
    Filter decoder({}, told);
    decoder.observe(at(0ms), at(3s), fired_with(told, {1.15, 0.92, 1.05, 0.88, 1.0, 1.1, 0.95, 0.97, 0.98}));
    const Estimate estimate = decoder.estimate(at(3s));
    // The mean gain is exact.
    EXPECT_NEAR(estimate.force_n, 8, 0.01 * 8);
    EXPECT_EQ(estimate.left_out, 0);
}

// Gains are said to be off by 5 %, and are off by 18 %. Sigma contains the standard error of their mean.
TEST(Filter, GainsThatDepartByMoreThanIsStatedMakeItLessSure) {
    DecodedAfferents told = fingers(std::vector(5, 1.0));
    told.uncertainty.gain = 0.05;
    const std::vector<double> gains{1.2, 0.8, 1.15, 0.85, 1.0};
    Filter decoder({}, told);
    decoder.observe(at(0ms), at(3s), fired_with(told, gains));
    double squares = 0;
    for (const double gain : gains) squares += std::pow(gain - 1, 2);
    EXPECT_NEAR(decoder.estimate(at(3s)).sigma_n, 8 * std::sqrt(squares / 4 / 5), 0.01);
}

// Gains wander only where several contradict what is expected: one that is wild casts no doubt on the other
// eight.
TEST(Filter, OneThatIsWildMakesNoOtherLessCertain) {
    DecodedAfferents afferents = fingers(std::vector(9, 1.0));
    afferents.uncertainty = Uncertainty();
    auto events = all_fired(afferents, 3s, [](double) { return 8.0; });
    std::erase_if(events, [](const Event& event) { return event.address == 2; });
    const auto sigma_n = [&](const std::vector<Event>& heard) {
        Filter decoder({}, afferents);
        decoder.observe(at(0ms), at(3s), heard);
        EXPECT_TRUE(decoder.left_out(2));
        return decoder.estimate(at(3s)).sigma_n;
    };
    const double of_eight_n = sigma_n(events);
    std::mt19937 random(1);
    std::exponential_distribution<double> wait_s(80);
    for (double time_s = wait_s(random); time_s < 3; time_s += wait_s(random))
        events.push_back({at(rounded(Seconds(time_s))), 2});
    std::sort(events.begin(), events.end());
    // A few spikes pass before the wild afferent is rejected.
    EXPECT_LT(sigma_n(events), 1.005 * of_eight_n);
}

// Where only one afferent is heard, each of its spikes shows that the force has not fallen faster than
// silence would have shown.
TEST(Filter, FollowsOneAfferentWithoutOvershooting) {
    const auto force_n = [](double time_s) {
        if (time_s < 1.5) return std::clamp(80 * (time_s - 0.5), 0.0, 8.0);
        return std::max(0.0, 8 - 5 * (time_s - 1.5));
    };
    const DecodedAfferents one = fingers({3.0});
    const auto events = all_fired(one, 4s, force_n);
    Filter decoder({}, one);
    const Score found = score(decoder, events, 4s, force_n, nothing);
    EXPECT_LT(found.largest_n, 8.5);
    EXPECT_LT(found.rms_n, 0.15);
}

TEST(Filter, SigmaContainsWhatAllElementsMayHaveInCommon) {
    DecodedAfferents afferents = fingers({1.2, 1.0, 0.8});
    afferents.uncertainty.common_gain = 0.1;
    const auto events = all_fired(afferents, 2s, [](double) { return 7.0; });
    Filter decoder({}, afferents);
    decoder.observe(at(0ms), at(2s), events);
    EXPECT_NEAR(decoder.estimate(at(2s)).sigma_n, 0.1 * 7, 0.05 * 0.7);
}

TEST(Filter, FourOfNineThatDieInAGripAreKnownWithinHalfASecond) {
    const DecodedAfferents afferents = fingers({1.8, 1.6, 1.1, 1.0, 0.9, 0.5, 0.9, 0.7, 0.5});
    auto events = all_fired(afferents, 4s, [](double) { return 7.0; });
    std::erase_if(events, [](const Event& event) { return event.address < 4 && event.time > at(2s); });
    Filter decoder({}, afferents);
    const auto middle = std::lower_bound(events.begin(), events.end(), Event{at(2500ms), 0});
    decoder.observe(at(0ms), at(2500ms), {events.begin(), middle});
    EXPECT_EQ(decoder.estimate(at(2500ms)).left_out, 4);
    decoder.observe(at(2500ms), at(4s), {middle, events.end()});
    EXPECT_NEAR(decoder.estimate(at(4s)).force_n, 7, 0.05 * 7);
}

// Two fingers carry what a third does not, or the third is dead: nobody can tell, and two sigma cover both.
TEST(Filter, AFingerThatIsNotHeardIsUnloadedOrDead) {
    DecodedAfferents afferents = fingers({1, 1, 1, 1, 1, 1});
    for (auto& afferent : afferents.afferents) afferent.patch = afferent.address / 2;
    auto events = all_fired(afferents, 3s, grasp_n);
    std::erase_if(events, [](const Event& event) { return event.address < 2; });
    Filter decoder({}, afferents);
    decoder.observe(at(0ms), at(1500ms),
                    {events.begin(), std::lower_bound(events.begin(), events.end(), Event{at(1500ms), 0})});
    const Estimate estimate = decoder.estimate(at(1500ms));
    EXPECT_EQ(estimate.doubt, Doubt::unheard);
    EXPECT_NEAR(estimate.force_n, 8.0 * 2 / 3, 0.1) << "what the other two fingers' shares make of it";
    EXPECT_GT(estimate.force_n + 2 * estimate.sigma_n, 8) << "what they read";
}

TEST(Filter, ForcesOfAnotherSizeAreDecodedAlike) {
    const DecodedAfferents afferents = fingers({1.2, 1.0, 0.8});
    DecodedAfferents strong = afferents;
    strong.largest_grip_n *= 100;
    for (auto& group : strong.groups) group.drive_mv_per_n /= 100;
    const auto events = all_fired(afferents, 2s, grasp_n);
    Filter one({}, afferents);
    Filter other({}, strong);
    one.observe(at(0ms), at(2s), events);
    other.observe(at(0ms), at(2s), events);
    EXPECT_NEAR(other.estimate(at(2s)).force_n, 100 * one.estimate(at(2s)).force_n, 1e-6);
    EXPECT_NEAR(other.estimate(at(2s)).sigma_n, 100 * one.estimate(at(2s)).sigma_n, 1e-6);
}

TEST(Filter, RefusesASnapshotOfOtherAfferents) {
    Filter decoder({}, fingers({1}));
    EXPECT_THROW(decoder.resume(Filter({}, fingers({1, 1})).snapshot()), ParameterError);
}

}  // namespace
}  // namespace afferent
