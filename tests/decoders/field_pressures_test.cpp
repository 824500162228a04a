// The pressures under the fields of two afferents: what spikes measure, silence bounds, and age and losses
// blur.
#include "afferent/decoders/field_pressures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "afferent/runtime/parameter_error.hpp"
#include "tests/decoders/afferents.hpp"

namespace afferent {
namespace {

constexpr double unit_n_per_mm2 = 0.002;
constexpr double full_scale = 20;  // in units

// Sensors with a noise of so many units.
DecodedAfferents two_afferents(double noise = 0) {
    DecodedAfferents afferents{.addresses = 2, .largest_grip_n = 20};
    DecodedAfferents::Group group = group_with(2);
    group.full_scale_n = full_scale;
    group.noise_n = noise;
    afferents.add(0, group, 0.5);
    afferents.add(1, group, 0.5);
    return afferents;
}

// The first afferent is pressed by so many units until a time.
struct Pressed {
    Pressed(double units, Duration until, double noise = 0)
        : pressures(two_afferents(noise), {unit_n_per_mm2, unit_n_per_mm2}),
          events(fired(
              two_afferents().groups[0], until, [=](double) { return units; }, 0)) {}

    // In units.
    std::array<PressureFit::Reading, 2> readings(Duration now) {
        std::array<PressureFit::Reading, 2> all{};
        feel = pressures.read(at(now), all);
        for (PressureFit::Reading& reading : all)
            for (double* const value : {&reading.lowest, &reading.highest, &reading.below, &reading.above})
                *value /= unit_n_per_mm2;
        return all;
    }

    FieldPressures pressures;
    std::vector<Event> events;
    std::uint32_t feel = 0;
};

TEST(FieldPressures, AreMeasuredBySpikesAndBoundedBySilence) {
    Pressed pressed(5, 400ms);
    ASSERT_GT(pressed.events.size(), 3U);
    pressed.pressures.observe(at(0ms), at(400ms), pressed.events);
    const auto [touched, untouched] = pressed.readings(400ms);
    EXPECT_EQ(pressed.feel, 1U);
    EXPECT_NEAR(touched.lowest, 5, 0.05);
    EXPECT_GE(touched.highest, touched.lowest);
    EXPECT_LT(touched.highest, 5.5);
    EXPECT_EQ(untouched.lowest, 0);
    // Both fire from 0.3 units on.
    EXPECT_NEAR(untouched.highest, 0.3, 0.05);
}

// What silence leaves possible below full scale is a bound. What it leaves possible up to there is none, as a
// sensor at full scale may feel any pressure.
TEST(FieldPressures, AreBoundedBelowFullScaleOrNotAtAll) {
    Pressed pressed(5, 1ms, 0.5);
    int bounded = 0;
    for (Duration now = 0ms; now <= 60ms; now += 100us) {
        pressed.pressures.presume_silence(at(now));
        const PressureFit::Reading reading = pressed.readings(now)[1];
        if (std::isinf(reading.highest)) {
            EXPECT_EQ(bounded, 0) << seconds(now) << ": silence goes on, and tells more";
            continue;
        }
        ++bounded;
        EXPECT_LT(reading.highest + 2 * reading.above, 0.98 * full_scale) << seconds(now);
    }
    EXPECT_GT(bounded, 300);
    EXPECT_LT(bounded, 600);
}

TEST(FieldPressures, AreLessAndLessCertainAndForgottenAfterHalfASecond) {
    Pressed pressed(5, 400ms);
    pressed.pressures.observe(at(0ms), at(400ms), pressed.events);
    const Duration last = pressed.events.back().time - scene_start;
    double before = 0;
    for (const Duration age : {20ms, 100ms, 300ms}) {
        const PressureFit::Reading reading = pressed.readings(last + age)[0];
        EXPECT_GT(reading.below, before);
        before = reading.below;
    }
    EXPECT_EQ(pressed.readings(last + 600ms)[0].lowest, 0);
}

// The second afferent fires too rarely to be missed yet.
TEST(FieldPressures, AreLessCertainWhereOthersFallSilent) {
    const auto uncertain_of_second = [](Duration first_pressed_until) {
        FieldPressures pressures(two_afferents(), {unit_n_per_mm2, unit_n_per_mm2});
        const auto group = two_afferents().groups[0];
        std::vector<Event> events = fired(
            group, first_pressed_until, [](double) { return 5; }, 0);
        const auto of_second = fired(
            group, 400ms, [](double) { return 0.6; }, 1);
        events.insert(events.end(), of_second.begin(), of_second.end());
        std::sort(events.begin(), events.end());
        pressures.observe(at(0ms), at(450ms), events);
        std::array<PressureFit::Reading, 2> readings{};
        pressures.read(at(450ms), readings);
        EXPECT_NEAR(readings[1].lowest, 0.6 * unit_n_per_mm2, 0.05 * unit_n_per_mm2);
        return readings[1].below;
    };
    const double heard = uncertain_of_second(450ms);
    const double silent = uncertain_of_second(400ms);
    EXPECT_GT(silent, 2 * heard);
    // The first felt 5 units, and has been silent for 50 ms. As an afferent is silent once a quarter of its
    // pressure is gone, it may have lost four times as much. The second may have changed twice as fast, for
    // the 60 ms at most since its last measurement.
    EXPECT_LT(silent, 2 * 4 * 5 * unit_n_per_mm2 / 0.05 * 0.06);
}

TEST(FieldPressures, MayHaveChangedTenTimesAsFastInWhatWasLost) {
    static constexpr Duration age = 60ms;
    const auto changed = [](Duration lost) {
        Pressed pressed(5, 400ms);
        pressed.pressures.observe(at(0ms), at(400ms), pressed.events);
        pressed.pressures.lose(at(400ms), at(400ms + lost));
        const Duration now = pressed.events.back().time + age - scene_start;
        return std::sqrt(std::pow(pressed.readings(now)[0].below, 2) -
                         std::pow(pressed.readings(now - age)[0].below, 2));
    };
    const double heard = changed(0ms);
    // A quarter of the time, and half of it; the measurement is some milliseconds older than the spike.
    EXPECT_NEAR(changed(15ms) / heard, 0.75 + 10 * 0.25, 0.4);
    EXPECT_NEAR(changed(30ms) / heard, 0.5 + 10 * 0.5, 0.4);
}

// A transient afferent fires at a fall by a tenth of the pressure on the first sustained one.
struct Told {
    Told()
        : pressures(two_afferents_of(3), {unit_n_per_mm2, unit_n_per_mm2},
                    std::array{SkinField{0, 0, 0.25}, SkinField{5, 0, 0.25}},
                    {{2, {0, 0, 0.25}, 0.06 * unit_n_per_mm2, 0.006 * unit_n_per_mm2, 0.03}}),
          events(fired(
              two_afferents().groups[0], 400ms, [](double) { return 0.6; }, 0)) {}

    static DecodedAfferents two_afferents_of(std::size_t addresses) {
        DecodedAfferents afferents = two_afferents();
        afferents.addresses = addresses;
        return afferents;
    }
    // In units, some time after the last spike of the sustained one, and after those of the transient one.
    PressureFit::Reading reading(const std::vector<Duration>& transient, bool slides = false) {
        const Duration last = events.back().time - scene_start;
        std::vector<Event> all = events;
        all.insert(all.begin(), {at(1ms), 2});
        for (const Duration after : transient) all.push_back({at(last + after), 2});
        std::sort(all.begin(), all.end());
        pressures.take_for_sliding(slides);
        pressures.observe(at(0ms), at(last + 20ms), all);
        std::array<PressureFit::Reading, 2> readings{};
        change = pressures.change(at(last + 20ms));
        pressures.read(at(last + 20ms), readings, change);
        common_sigma = pressures.common_sigma(at(last + 20ms), change);
        return {readings[0].lowest / unit_n_per_mm2, 0, readings[0].below / unit_n_per_mm2, 0};
    }

    FieldPressures pressures;
    std::vector<Event> events;
    CommonChange::Factor change;
    double common_sigma = 0;
};

TEST(FieldPressures, FallWhereTransientAfferentsFireAndSustainedOnesAreSilent) {
    Told held, fallen, sliding;
    const PressureFit::Reading before = held.reading({});
    EXPECT_NEAR(before.lowest, 0.6, 0.05);
    EXPECT_EQ(held.change, CommonChange::Factor());
    EXPECT_EQ(held.common_sigma, 0);
    const PressureFit::Reading after = fallen.reading({5ms, 8ms, 12ms});
    EXPECT_LT(after.lowest, 0.9 * before.lowest);
    EXPECT_GT(after.below, before.below);
    EXPECT_DOUBLE_EQ(after.lowest, fallen.change.mean * before.lowest);
    // All of the pressure was measured before.
    EXPECT_DOUBLE_EQ(fallen.common_sigma, fallen.change.sigma / fallen.change.mean);
    EXPECT_EQ(sliding.reading({5ms, 8ms, 12ms}, true).lowest, before.lowest);
}

// A transient afferent fires at a rise as well. What sustained ones measure of it keeps the pressures from
// falling.
TEST(FieldPressures, DoNotFallWhereASustainedAfferentMeasuresARise) {
    Told told;
    const Duration last = told.events.back().time - scene_start;
    std::vector<Event> all = fired(
        two_afferents().groups[0], last + 100ms,
        [&](double time_s) { return time_s > seconds(last) ? 5 : 0.6; }, 0);
    const auto fires_within = [&](Duration begin, Duration end) {
        return std::ranges::any_of(all, [&](const Event& event) {
            return event.time > at(last + begin) && event.time < at(last + end);
        });
    };
    ASSERT_TRUE(fires_within(4ms, 19ms)) << "while the pressure changes";
    ASSERT_TRUE(fires_within(60ms, 99ms)) << "and after it";
    all.insert(all.end(), {{at(1ms), 2}, {at(last + 3ms), 2}, {at(last + 6ms), 2}});
    std::ranges::sort(all);
    const auto after = std::ranges::lower_bound(all, Event{at(last + 19ms), 0});
    told.pressures.observe(at(0ms), at(last + 19ms), {all.begin(), after});
    EXPECT_GT(told.pressures.change(at(last + 19ms)).mean, 0.97);
    told.pressures.observe(at(last + 19ms), at(last + 100ms), {after, all.end()});
    EXPECT_GT(told.pressures.change(at(last + 100ms)).mean, 0.97);
}

// The second afferent fires often, so that its last measurement is later than the change.
TEST(FieldPressures, ShareTheErrorOfAChangeOnlyIfMeasuredBeforeIt) {
    Told told;
    const Duration last = told.events.back().time - scene_start;
    std::vector<Event> all = told.events;
    const auto of_second = fired(
        two_afferents().groups[0], last + 40ms, [](double) { return 5; }, 1);
    all.insert(all.end(), of_second.begin(), of_second.end());
    all.insert(all.end(), {{at(1ms), 2}, {at(last + 2ms), 2}, {at(last + 5ms), 2}});
    std::ranges::sort(all);
    const TimePoint now = at(last + 40ms);
    told.pressures.observe(at(0ms), now, all);
    const CommonChange::Factor change = told.pressures.change(now);
    ASSERT_GT(change.sigma, 0);
    std::array<PressureFit::Reading, 2> readings{};
    told.pressures.read(now, readings, change);
    const double before = readings[0].lowest / change.mean;
    EXPECT_NEAR(before, 0.6 * unit_n_per_mm2, 0.05 * unit_n_per_mm2);
    EXPECT_NEAR(told.pressures.common_sigma(now, change),
                change.sigma * before / (readings[0].lowest + readings[1].lowest), 1e-9);
}

TEST(FieldPressures, RefuseFieldsOfOtherAfferents) {
    const CommonChange::Transient transient{1, {0, 0, 0.25}, 1, 1, 0.03};
    EXPECT_THROW((FieldPressures(two_afferents(), {1, 1}, std::array{SkinField{0, 0, 0.25}}, {transient})),
                 ParameterError);
}

// What was told of one change stays with the measurement when the next one begins, and in a snapshot.
TEST(FieldPressures, RememberWhatHasChanged) {
    Told told;
    const double after = told.reading({5ms}).lowest;
    FieldPressures& pressures = told.pressures;
    Told other;
    other.pressures.resume(pressures.snapshot());
    EXPECT_EQ(other.pressures.change(at(450ms)), pressures.change(at(450ms)));
    const TimePoint next = told.events.back().time + 150ms;
    pressures.observe(told.events.back().time + 20ms, next + 1ms, std::vector<Event>{{next, 2}});
    const CommonChange::Factor second = pressures.change(next + 1ms);
    EXPECT_LT(second.mean, 1);
    std::array<PressureFit::Reading, 2> readings{};
    pressures.read(next + 1ms, readings);
    EXPECT_LT(readings[0].lowest / unit_n_per_mm2, after + 1e-9);
    EXPECT_GT(readings[0].lowest, 0);
    pressures.resume_after(next, next);
    EXPECT_EQ(pressures.change(next), CommonChange::Factor());
}

// After a restart nothing is known to slide.
TEST(FieldPressures, ForgetThatAContactSlid) {
    Told told;
    told.pressures.take_for_sliding(true);
    told.pressures.resume_after(scene_start, scene_start);
    std::vector<Event> all = told.events;
    all.insert(all.begin(), {at(1ms), 2});
    const TimePoint later = all.back().time + 5ms;
    all.push_back({later, 2});
    told.pressures.observe(at(0ms), later + 15ms, all);
    EXPECT_LT(told.pressures.change(later + 15ms).mean, 1);
}

}  // namespace
}  // namespace afferent
