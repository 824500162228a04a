// Waves and roughness in trains of spikes that are made up.
#include "afferent/decoders/texture.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

#include "afferent/runtime/parameter_error.hpp"
#include "afferent/runtime/summary.hpp"
#include "tests/since_start.hpp"

namespace afferent {
namespace {

// Sixty-four afferents some 1.2 mm apart, at the addresses 1 to 64 of 66, and windows of 400 ms. Their fields
// are so narrow that the fall of a contact's pressure changes k by 0.3 %.
TextureReadout::Parameters skin_of_64() {
    TextureReadout::Parameters parameters{.addresses = 66, .patch = {2}, .window = 400ms};
    std::mt19937 random(5);
    std::uniform_real_distribution<double> jitter(-0.3, 0.3);
    for (int i = 0; i < 64; ++i)
        parameters.afferents.push_back(
            {static_cast<Address>(i + 1),
             {1.2 * (i % 8 - 3.5) + jitter(random), 1.2 * (i / 8 - 3.5) + jitter(random), 0.05}});
    return parameters;
}

struct SlidSurface {
    double period_mm, speed_mm_per_s, direction_deg;
    double depth = 0.8;   // of the modulation, 0 to 1
    double harmonic = 0;  // depth of the second
    double mean_hz = 40;
};

// Poisson spikes of the rate mean · (1 + depth cos(ωt − k·x) + harmonic cos 2(ωt − k·x)), by thinning.
std::vector<Event> slid_over(const TextureReadout::Parameters& skin, const SlidSurface& surface,
                             unsigned seed, double duration_s) {
    std::mt19937_64 random(seed);
    std::vector<Event> events;
    const double most_hz = surface.mean_hz * (1 + surface.depth + surface.harmonic);
    const double angle = surface.direction_deg * std::numbers::pi / 180;
    for (const auto& afferent : skin.afferents) {
        const double along_mm = afferent.field.x_mm * std::cos(angle) + afferent.field.y_mm * std::sin(angle);
        std::exponential_distribution<double> interval(most_hz);
        std::uniform_real_distribution<double> part(0, most_hz);
        for (double time_s = interval(random); time_s < duration_s; time_s += interval(random)) {
            const double phase =
                2 * std::numbers::pi * (surface.speed_mm_per_s * time_s - along_mm) / surface.period_mm;
            const double rate_hz = surface.mean_hz * (1 + surface.depth * std::cos(phase) +
                                                      surface.harmonic * std::cos(2 * phase));
            if (part(random) < rate_hz)
                events.push_back({at(Duration(std::llround(time_s * 1e9))), afferent.address});
        }
    }
    std::sort(events.begin(), events.end());
    return events;
}

void hear_span(TextureReadout& readout, std::span<const Event> events, Duration begin, Duration end) {
    const auto from = std::ranges::lower_bound(events, at(begin), {}, &Event::time);
    const auto until = std::ranges::lower_bound(events, at(end), {}, &Event::time);
    readout.observe(at(begin), at(end), {from, until});
}

// The windows that are told while spans of 5 ms are heard, with a step after each, and in the steps that the
// last fit takes.
std::vector<PatchTexture> hear(TextureReadout& readout, std::span<const Event> events, Duration begin,
                               Duration end, const std::function<bool(Duration)>& lost = {}) {
    std::vector<PatchTexture> told;
    const auto step = [&] {
        if (const auto one = readout.step(at(begin))) told.push_back(*one);
    };
    while (begin < end) {
        if (lost && lost(begin))
            readout.lose(at(begin), at(begin + 5ms));
        else
            hear_span(readout, events, begin, begin + 5ms);
        begin += 5ms;
        step();
    }
    for (int i = 0; i < 50; ++i) step();
    return told;
}

// The window that is told, and the steps that it takes.
struct Told {
    std::optional<PatchTexture> window;
    int steps = 0;
    friend bool operator==(const Told&, const Told&) = default;
};
Told step_until_told(TextureReadout& readout, TimePoint now) {
    Told told;
    while (!told.window && told.steps < 1000) {
        told.window = readout.step(now);
        ++told.steps;
    }
    return told;
}

double angle_between(double one_deg, double other_deg) {
    return std::abs(std::remainder(one_deg - other_deg, 360));
}

// A Poisson train of n spikes tells the phase of a modulation of the depth m within √(2/n)/m; the spread of
// the places, 2.8 mm in each direction, and that of the times, 400 ms/√12, divide it.
TEST(TextureReadout, TellsPeriodDirectionAndSpeed) {
    const auto skin = skin_of_64();
    int count = 0;
    double period_off = 0, speed_off = 0, direction_off = 0;
    int within_two[3]{};
    for (unsigned seed = 1; seed <= 40; ++seed) {
        const SlidSurface surface{1.6 + 0.1 * seed, 25 + 2.0 * seed, 47.0 * seed};
        const auto events = slid_over(skin, surface, seed, 0.4);
        TextureReadout readout(skin);
        const auto told = hear(readout, events, 0ms, 405ms);
        ASSERT_EQ(told.size(), 1U);
        EXPECT_EQ(told[0].end, at(400ms));
        EXPECT_EQ(told[0].patch.value, 2U);
        EXPECT_EQ(told[0].afferents, 64U);
        EXPECT_EQ(told[0].events, events.size());
        const TextureEstimate& found = told[0].estimate;
        ASSERT_TRUE(found.slides) << seed;
        const double n = static_cast<double>(events.size());
        const double phase = std::sqrt(2 / n) / surface.depth;
        const double k = 2 * std::numbers::pi / surface.period_mm;
        const double k_sigma = phase / 2.8;
        const double omega_sigma = phase / (0.4 / std::sqrt(12.0));
        const double off[3]{(found.period_mm / surface.period_mm - 1) / (k_sigma / k),
                            angle_between(found.direction_deg, surface.direction_deg) * std::numbers::pi /
                                180 / (k_sigma / k),
                            (found.frequency_hz - surface.speed_mm_per_s / surface.period_mm) * 2 *
                                std::numbers::pi / omega_sigma};
        period_off += off[0] * off[0];
        direction_off += off[1] * off[1];
        speed_off += off[2] * off[2];
        within_two[0] += std::abs(found.period_mm - surface.period_mm) < 2 * found.period_sigma_mm;
        within_two[1] +=
            angle_between(found.direction_deg, surface.direction_deg) < 2 * found.direction_sigma_deg;
        within_two[2] +=
            std::abs(found.speed_mm_per_s - surface.speed_mm_per_s) < 2 * found.speed_sigma_mm_per_s;
        ++count;
    }
    // Squares of a normal number have the variance 2: three deviations of the mean of forty.
    for (const double squares : {period_off, direction_off, speed_off})
        EXPECT_LT(squares / count, 1 + 3 * std::sqrt(2.0 / count));
    for (const int within : within_two) EXPECT_GE(within, count * 0.95 - 3 * std::sqrt(count * 0.95 * 0.05));
}

// The second harmonic is five times as strong as the wave itself.
// An afferent that is silent is no witness: what the others tell is as sure as without it.
TEST(TextureReadout, IsNoSurerOfAWaveForAfferentsThatAreSilent) {
    const auto skin = skin_of_64();
    auto events = slid_over(skin, {2, 40, 30}, 1, 0.4);
    std::erase_if(events, [](const Event& event) { return event.address % 2 == 0; });
    auto every_second = skin;
    std::erase_if(every_second.afferents, [](const auto& afferent) { return afferent.address % 2 == 0; });
    TextureReadout all(skin), those(every_second);
    const auto of_all = hear(all, events, 0ms, 405ms);
    const auto of_those = hear(those, events, 0ms, 405ms);
    ASSERT_EQ(of_all.size(), 1U);
    ASSERT_EQ(of_those.size(), 1U);
    ASSERT_TRUE(of_all[0].estimate.slides && of_those[0].estimate.slides);
    EXPECT_NEAR(of_all[0].estimate.period_mm, of_those[0].estimate.period_mm, 1e-6);
    EXPECT_NEAR(of_all[0].estimate.period_sigma_mm / of_those[0].estimate.period_sigma_mm, 1, 1e-6);
}

TEST(TextureReadout, TellsAWaveFromItsHarmonics) {
    const auto skin = skin_of_64();
    for (unsigned seed = 1; seed <= 8; ++seed) {
        TextureReadout readout(skin);
        const auto events = slid_over(skin, {4, 60, 30.0 * seed, 0.3, 0.5, 60}, seed, 0.4);
        const auto told = hear(readout, events, 0ms, 405ms);
        ASSERT_EQ(told.size(), 1U);
        ASSERT_TRUE(told[0].estimate.slides) << seed;
        EXPECT_NEAR(told[0].estimate.period_mm, 4, 0.4) << seed;
    }
}

// One false alarm in a thousand windows is allowed: two in a hundred have a chance of 0.5 %.
TEST(TextureReadout, TellsNoWaveOfWhatHasNone) {
    const auto skin = skin_of_64();
    const auto events = slid_over(skin, {2, 40, 0, 0, 0, 20}, 7, 40);
    TextureReadout readout(skin);
    int sliding = 0;
    const auto told = hear(readout, events, 0ms, 40s + 5ms);
    ASSERT_EQ(told.size(), 100U);
    for (const PatchTexture& texture : told) sliding += texture.estimate.oscillates;
    EXPECT_LE(sliding, 1);
}

// What all afferents feel at once is no wave over the skin: its length is infinite.
TEST(TextureReadout, TellsOnlyTheFrequencyOfWhatVibrates) {
    const auto skin = skin_of_64();
    const auto events = slid_over(skin, {1e6, 30e6, 0, 0.8, 0, 40}, 3, 0.4);
    TextureReadout readout(skin);
    const auto told = hear(readout, events, 0ms, 405ms);
    ASSERT_EQ(told.size(), 1U);
    EXPECT_TRUE(told[0].estimate.oscillates);
    EXPECT_NEAR(told[0].estimate.frequency_hz, 30, 0.3);
    EXPECT_FALSE(told[0].estimate.slides);
}

// Each afferent's interval is constant, whatever it is: that gains differ is not rough.
TEST(TextureReadout, TellsNoRoughnessOfSteadyRates) {
    const auto skin = skin_of_64();
    std::vector<Event> events;
    for (const auto& afferent : skin.afferents)
        for (Duration time = 3ms; time < 400ms; time += Duration(8ms + afferent.address * 300us))
            events.push_back({at(time), afferent.address});
    std::sort(events.begin(), events.end());
    TextureReadout readout(skin);
    const auto told = hear(readout, events, 0ms, 405ms);
    ASSERT_EQ(told.size(), 1U);
    ASSERT_TRUE(told[0].estimate.felt);
    // The last interval is cut by the window.
    EXPECT_LT(told[0].estimate.roughness_hz, 0.5);
}

// Half of the afferents fire at 20 Hz and then at 60 Hz, the other half the other way round: each differs
// from its mean by 20 Hz. Of neighbours in columns 1 to 3 mm apart some two thirds are of the other half.
TEST(TextureReadout, TellsRoughnessByHowNeighboursDiffer) {
    auto skin = skin_of_64();
    for (int i = 0; i < 64; ++i) skin.afferents[i].field = {1.2 * (i % 8), 1.2 * (i / 8), 0.3};
    std::vector<Event> events;
    for (int i = 0; i < 64; ++i) {
        const bool first_fast = (i % 8 + i / 8) % 2 == 0;
        const auto fire = [&](Duration begin, Duration interval) {
            for (Duration time = begin; time < begin + 200ms; time += interval)
                events.push_back({at(time), skin.afferents[i].address});
        };
        fire(0ms, first_fast ? 10ms : 40ms);
        fire(200ms, first_fast ? 40ms : 10ms);
    }
    std::sort(events.begin(), events.end());
    // Neighbours on a board of squares: those of the other colour differ by 100 − 25 Hz at all times.
    double mean = 0;
    for (int i = 0; i < 64; ++i) {
        int pairs = 0, others = 0;
        for (int j = 0; j < 64; ++j) {
            const double apart = 1.2 * std::hypot(i % 8 - j % 8, i / 8 - j / 8);
            if (apart < 1 || apart > 3) continue;
            ++pairs;
            others += (i % 8 + i / 8 + j % 8 + j / 8) % 2;
        }
        mean += 75.0 * others / pairs / 64;
    }
    TextureReadout readout(skin);
    const auto told = hear(readout, events, 0ms, 405ms);
    ASSERT_EQ(told.size(), 1U);
    ASSERT_TRUE(told[0].estimate.felt);
    // One sample of forty at each change of rate may belong to the interval before.
    EXPECT_NEAR(told[0].estimate.roughness_hz, mean, 2 * mean / 40);
}

// A tenth of the spans: the spikes are fewer, and the wave the same.
TEST(TextureReadout, TellsWavesThroughLosses) {
    const auto skin = skin_of_64();
    const auto events = slid_over(skin, {2.5, 50, 130}, 11, 0.8);
    std::mt19937 random(1);
    TextureReadout readout(skin);
    const auto told = hear(readout, events, 0ms, 805ms, [&](Duration) { return random() % 10 == 0; });
    ASSERT_EQ(told.size(), 2U);
    for (const PatchTexture& texture : told) {
        ASSERT_TRUE(texture.estimate.slides);
        EXPECT_NEAR(texture.estimate.period_mm, 2.5, 3 * texture.estimate.period_sigma_mm);
    }
}

TEST(TextureReadout, TellsNothingOfAWindowThatIsMostlyLost) {
    const auto skin = skin_of_64();
    const auto events = slid_over(skin, {2.5, 50, 130}, 12, 1.2);
    for (const bool told_so : {false, true}) {
        TextureReadout readout(skin);
        auto told = hear(readout, events, 0ms, 500ms);
        ASSERT_EQ(told.size(), 1U);
        // The rest of the second window, of which a quarter has been heard.
        if (told_so) readout.lose(at(500ms), at(790ms));
        told = hear(readout, events, 790ms, 1205ms);
        ASSERT_EQ(told.size(), 1U);
        EXPECT_EQ(told[0].end, at(1200ms));
    }
    // In the middle nobody knows what has been before.
    TextureReadout readout(skin);
    readout.restart(at(650ms));
    const auto told = hear(readout, events, 650ms, 1205ms);
    ASSERT_EQ(told.size(), 1U);
    EXPECT_EQ(told[0].end, at(1200ms));
}

// A loss of years costs no more than one of seconds.
TEST(TextureReadout, SkipsWindowsInWhichNothingIsHeard) {
    const auto skin = skin_of_64();
    TextureReadout readout(skin);
    const Duration late = std::chrono::hours(24 * 365 * 20);
    readout.lose(at(0ms), at(late));
    const auto told = hear(readout, {}, late, late + 900ms);
    ASSERT_FALSE(told.empty());
    EXPECT_EQ(told[0].afferents, 0U);
    EXPECT_FALSE(told[0].estimate.oscillates);
    EXPECT_FALSE(told[0].estimate.felt);
}

TEST(TextureReadout, ContinuesFromASnapshotBitForBit) {
    const auto skin = skin_of_64();
    const auto events = slid_over(skin, {2, 40, 10}, 13, 0.4);
    TextureReadout readout(skin), other(skin);
    EXPECT_TRUE(hear(readout, events, 0ms, 200ms).empty());
    other.resume(readout.snapshot());
    const auto told = hear(readout, events, 200ms, 405ms);
    ASSERT_EQ(told.size(), 1U);
    EXPECT_EQ(hear(other, events, 200ms, 405ms), told);
    auto fewer = skin;
    fewer.afferents.pop_back();
    EXPECT_THROW(TextureReadout(fewer).resume(readout.snapshot()), ParameterError);
    auto longer = skin;
    longer.window = 500ms;
    EXPECT_THROW(TextureReadout(longer).resume(readout.snapshot()), ParameterError);
}

TEST(TextureReadout, TakesThePartsOfASpanInAnyOrder) {
    const auto skin = skin_of_64();
    const auto events = slid_over(skin, {2, 40, 10}, 14, 0.4);
    TextureReadout whole(skin), parts(skin);
    whole.observe(at(0ms), at(400ms), events);
    const std::size_t half = events.size() / 2;
    parts.observe(at(0ms), at(400ms), std::span(events).subspan(half));
    parts.observe(at(0ms), at(400ms), std::span(events).first(half));
    EXPECT_FALSE(parts.step(at(400ms))) << "another part may come";
    for (TextureReadout* each : {&whole, &parts}) each->observe(at(400ms), at(405ms), {});
    const Told told = step_until_told(whole, at(405ms));
    ASSERT_TRUE(told.window);
    EXPECT_EQ(step_until_told(parts, at(405ms)), told);
}

TEST(TextureReadout, CountsWhatItDrops) {
    const auto skin = skin_of_64();
    TextureReadout readout(skin);
    // A window has room for 161 spikes of an afferent.
    std::vector<Event> events;
    for (int i = 0; i < 200; ++i) events.push_back({at(i * 1ms), 3});
    readout.observe(at(0ms), at(400ms), events);
    EXPECT_EQ(readout.dropped(), 39U);
    // Nobody takes the first window by the time at which the second must be told.
    readout.observe(at(400ms), at(800ms), {});
    readout.observe(at(800ms), at(1200ms), {});
    EXPECT_EQ(readout.dropped(), 39U);
    readout.observe(at(1200ms), at(1205ms), {});
    EXPECT_EQ(readout.dropped(), 40U);
}

std::vector<SkinField> fields_of(const TextureReadout::Parameters& skin) {
    std::vector<SkinField> fields;
    for (const auto& afferent : skin.afferents) fields.push_back(afferent.field);
    return fields;
}

// The fits of a window by themselves.
struct Fits {
    SpikeTrains trains{64, 400ms};
    WaveFit wave{fields_of(skin_of_64()), 400ms};
    SpatialVariation variation{fields_of(skin_of_64()), 400ms};
    TextureEstimate estimate;

    explicit Fits(std::span<const Event> events) {
        for (const Event& event : events)
            trains.add(event.address - 1, static_cast<std::uint32_t>((event.time - scene_start).count()));
    }
    // How much is done with each budget.
    std::vector<std::size_t> fit(std::size_t work) {
        estimate = {};
        wave.begin();
        variation.begin();
        std::vector<std::size_t> done;
        for (bool complete = false; !complete;) {
            WorkBudget budget(work);
            complete = wave.advance(trains, budget, estimate) && variation.advance(trains, budget, estimate);
            done.push_back(budget.done());
        }
        return done;
    }
};

constexpr std::size_t unbounded = std::numeric_limits<std::size_t>::max();

TEST(TextureFits, AreTheSameInPiecesOfAnySize) {
    // A wave that is found by its harmonic takes every part of the fit.
    Fits fits(slid_over(skin_of_64(), {4, 60, 30, 0.3, 0.5, 60}, 1, 0.4));
    EXPECT_EQ(fits.fit(unbounded).size(), 1U);
    const TextureEstimate at_once = fits.estimate;
    ASSERT_TRUE(at_once.slides && at_once.felt);
    EXPECT_NEAR(at_once.period_mm, 4, 0.4);
    for (const std::size_t work : {1, 1000, 54'321}) {
        fits.fit(work);
        EXPECT_EQ(fits.estimate, at_once) << work;
    }
}

TEST(TextureFits, DoNoMoreThanTheirBudget) {
    Fits fits(slid_over(skin_of_64(), {4, 60, 30, 0.3, 0.5, 60}, 1, 0.4));
    const std::size_t all = fits.fit(unbounded)[0];
    // No piece of the fits is larger than these.
    for (const std::size_t work : {5'000, 54'321}) {
        const auto done = fits.fit(work);
        EXPECT_LE(*std::ranges::max_element(done), work);
        EXPECT_EQ(std::accumulate(done.begin(), done.end(), std::size_t{0}), all);
    }
}

TEST(WorkBudget, DoesAPieceThatIsTooLargeAlone) {
    WorkBudget budget(10);
    EXPECT_TRUE(budget.take(4));
    EXPECT_FALSE(budget.take(7));
    EXPECT_TRUE(budget.take(6));
    EXPECT_FALSE(budget.take(1));
    EXPECT_EQ(budget.done(), 10U);
    WorkBudget other(10);
    EXPECT_TRUE(other.take(11));
    EXPECT_FALSE(other.take(1));
}

TEST(TextureReadout, DoesTheWorkOfOneStepInEach) {
    const auto events = slid_over(skin_of_64(), {2, 40, 10}, 15, 0.4);
    const std::size_t steps = Fits(events).fit(TextureReadout::work_a_step).size();
    ASSERT_GT(steps, 5U);
    TextureReadout readout(skin_of_64());
    readout.observe(at(0ms), at(400ms), events);
    readout.observe(at(400ms), at(405ms), {});
    const Told told = step_until_told(readout, at(405ms));
    EXPECT_TRUE(told.window);
    EXPECT_EQ(told.steps, static_cast<int>(steps));
}

// Returns the windows that are told in 2.8 s if each window has this many steps.
std::vector<PatchTexture> told_in(int steps_a_window, std::uint64_t& dropped) {
    const auto skin = skin_of_64();
    const auto events = slid_over(skin, {2, 40, 10}, 16, 2);
    TextureReadout readout(skin);
    std::vector<PatchTexture> told;
    for (Duration begin{}; begin < 2800ms; begin += 400ms / steps_a_window) {
        hear_span(readout, events, begin, begin + 400ms / steps_a_window);
        if (const auto one = readout.step(at(begin + 400ms / steps_a_window))) told.push_back(*one);
    }
    dropped = readout.dropped();
    return told;
}

TEST(TextureReadout, TellsEachWindowWhereStepsAreFew) {
    std::uint64_t dropped = 0;
    auto expected = told_in(80, dropped);
    ASSERT_GE(expected.size(), 5U);
    expected.resize(5);
    for (const int steps_a_window : {1, 2, 5}) {
        auto told = told_in(steps_a_window, dropped);
        ASSERT_GE(told.size(), 5U) << steps_a_window;
        told.resize(5);
        EXPECT_EQ(told, expected) << steps_a_window;
        EXPECT_EQ(dropped, 0U);
    }
}

// The first window is completed when the second ends. The fit of the second, which has no spikes, takes one
// step, and must not replace the first before that is taken.
TEST(TextureReadout, TellsTwoWindowsThatAreCompleteOneAfterTheOther) {
    auto skin = skin_of_64();
    skin.window = 20ms;
    TextureReadout readout(skin);
    readout.observe(at(0ms), at(20ms), slid_over(skin, {2, 40, 10}, 17, 0.02));
    readout.observe(at(20ms), at(40ms), {});
    readout.observe(at(40ms), at(45ms), {});
    std::vector<TimePoint> ends;
    for (int i = 0; i < 3; ++i)
        if (const auto told = readout.step(at(45ms))) ends.push_back(told->end);
    EXPECT_EQ(ends, (std::vector{at(20ms), at(40ms)}));
    EXPECT_EQ(readout.dropped(), 0U);
}

TEST(TextureReadout, CompletesAWindowWhenTheNextIsLost) {
    TextureReadout readout(skin_of_64());
    readout.observe(at(0ms), at(400ms), slid_over(skin_of_64(), {2, 40, 10}, 17, 0.4));
    readout.lose(at(400ms), at(795ms));
    EXPECT_FALSE(readout.step(at(795ms)));
    readout.lose(at(795ms), at(805ms));
    const auto told = readout.step(at(805ms));
    ASSERT_TRUE(told);
    EXPECT_EQ(told->end, at(400ms));
}

TEST(TextureReadout, ContinuesInTheMiddleOfAFit) {
    const auto skin = skin_of_64();
    const auto events = slid_over(skin, {2, 40, 10}, 18, 0.8);
    for (const int steps_before : {0, 1, 4}) {
        TextureReadout readout(skin), other(skin);
        hear_span(readout, events, 0ms, 400ms);
        hear_span(readout, events, 400ms, 500ms);
        for (int i = 0; i < steps_before; ++i) ASSERT_FALSE(readout.step(at(500ms)));
        // The other is in the middle of another fit.
        hear_span(other, events, 400ms, 805ms);
        EXPECT_FALSE(other.step(at(805ms)));
        other.resume(readout.snapshot());
        const Told told = step_until_told(readout, at(500ms));
        ASSERT_TRUE(told.window);
        EXPECT_EQ(told.window->end, at(400ms));
        EXPECT_EQ(step_until_told(other, at(500ms)), told) << steps_before;
        EXPECT_EQ(hear(other, events, 500ms, 805ms), hear(readout, events, 500ms, 805ms));
        // Where no fit is under way, the resumed one has none either.
        hear_span(other, events, 805ms, 1200ms);
        hear_span(other, events, 1200ms, 1205ms);
        other.resume(TextureReadout(skin).snapshot());
        EXPECT_FALSE(step_until_told(other, at(1205ms)).window);
    }
    TextureReadout readout(skin);
    hear_span(readout, events, 0ms, 405ms);
    hear_span(readout, events, 405ms, 410ms);
    auto snapshot = readout.snapshot();
    ASSERT_TRUE(snapshot.ended);
    snapshot.ended->trains = SpikeTrains(63, 400ms);
    EXPECT_THROW(readout.resume(snapshot), ParameterError);
    EXPECT_TRUE(step_until_told(readout, at(410ms)).window) << "nothing has changed";
}

TEST(TextureReadout, DropsTheFitWhenItRestarts) {
    const auto skin = skin_of_64();
    TextureReadout readout(skin);
    readout.observe(at(0ms), at(400ms), slid_over(skin, {2, 40, 10}, 19, 0.4));
    readout.observe(at(400ms), at(405ms), {});
    EXPECT_FALSE(readout.step(at(405ms)));
    readout.restart(at(405ms));
    EXPECT_FALSE(step_until_told(readout, at(405ms)).window);
    EXPECT_EQ(readout.dropped(), 0U);
}

// Steps that are so few that a window is told late in the next, or in a hurry after it.
TEST(TextureReadout, AgreesAfterItsHistoryWithOneThatHasAlwaysRun) {
    const auto skin = skin_of_64();
    const auto events = slid_over(skin, {2, 40, 10}, 20, 2.4);
    for (const Duration step : {5ms, 20ms, 80ms})
        for (const Duration start : {400ms, 480ms, 560ms, 640ms, 720ms}) {
            TextureReadout always(skin), later(skin);
            int compared = 0;
            for (Duration begin{}; begin < 2400ms; begin += step) {
                const Duration end = begin + step;
                hear_span(always, events, begin, end);
                const auto told = always.step(at(end));
                if (begin == start) later.restart(at(start));
                if (begin < start) continue;
                hear_span(later, events, begin, end);
                const auto told_later = later.step(at(end));
                if (begin < start + later.history()) continue;
                EXPECT_EQ(told_later, told) << start.count() << " " << step.count() << " " << end.count();
                compared += told.has_value();
            }
            EXPECT_GE(compared, 1);
        }
}

TEST(TextureReadout, CountsTheWindowsOfARunAndKeepsTheLastPeriod) {
    TextureReadout::Totals totals;
    totals.add({.patch = {2}, .estimate = {.felt = true, .roughness_hz = 7}});
    Summary summary;
    totals.add_to(summary, "tip");
    EXPECT_EQ(summary["texture"]["tip"].entries().size(), 3U);
    totals.add({.patch = {2}, .estimate = {.slides = true, .period_mm = 2, .period_sigma_mm = 0.1}});
    totals.add_to(summary, "tip");
    EXPECT_EQ(summary["texture"]["tip"]["windows"].number(), 2.0);
    EXPECT_EQ(summary["texture"]["tip"]["with_period"].number(), 1.0);
    EXPECT_EQ(summary["texture"]["tip"]["largest_roughness_hz"].number(), 7.0);
    EXPECT_EQ(summary["texture"]["tip"]["last_period_mm"].number(), 2.0);
    EXPECT_EQ(summary["texture"]["tip"]["last_period_sigma_mm"].number(), 0.1);
}

TEST(PatchTexture, LeavesEmptyWhatIsNotKnown) {
    PatchTexture texture{.patch = {2}, .estimate = {.frequency_hz = 1, .period_mm = 2, .roughness_hz = 3}};
    const auto known = [&] {
        std::string names;
        texture.columns([&](const std::string& name, const auto& value) {
            if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::optional<double>>)
                if (value && name.find("sigma") == std::string::npos) names += name + ' ';
        });
        return names;
    };
    EXPECT_EQ(known(), "");
    texture.estimate.felt = true;
    EXPECT_EQ(known(), "roughness_hz ");
    texture.estimate.oscillates = true;
    EXPECT_EQ(known(), "frequency_hz roughness_hz ");
    texture.estimate.slides = true;
    EXPECT_EQ(known(), "frequency_hz period_mm direction_deg speed_mm_per_s roughness_hz ");
}

TEST(TextureReadout, RefusesWhatItCannotRead) {
    auto parameters = skin_of_64();
    parameters.window = 19ms;
    EXPECT_THROW(TextureReadout{parameters}, ParameterError);
    parameters.window = 4001ms;
    EXPECT_THROW(TextureReadout{parameters}, ParameterError);
    parameters = skin_of_64();
    parameters.afferents[3].address = 66;
    EXPECT_THROW(TextureReadout{parameters}, ParameterError);
    parameters = skin_of_64();
    for (auto& afferent : parameters.afferents) afferent.field = {1, 1, 0.3};
    EXPECT_THROW(TextureReadout{parameters}, ParameterError);
    parameters.afferents.resize(1);
    EXPECT_THROW(TextureReadout{parameters}, ParameterError);
}

}  // namespace
}  // namespace afferent
