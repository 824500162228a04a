#include "afferent/decoders/exponential_rate.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "afferent/runtime/parameter_error.hpp"
#include "tests/decoders/afferents.hpp"

namespace afferent {
namespace {

constexpr Duration tau = 40ms;
constexpr double tau_s = 0.040;

double hz(const ExponentialRate& rate, Duration now) {
    const auto counts = rate.at(at(now));
    return counts.events() / counts.known_s();
}

// Mean and variance over phases of the rate at 2 s of a train that has always been regular; [lost_from,
// lost_until) is not heard of.
struct Moments {
    double mean_hz, variance_hz2, window_s;
};
Moments over_phases(Duration interval, int phases, Duration lost_from = 0ms, Duration lost_until = 0ms) {
    double sum = 0, squares = 0, window_s = 0;
    for (int phase = 0; phase < phases; ++phase) {
        ExponentialRate rate({true}, tau, false);
        // In the middle of each phase's part of the interval, so that sums over phases are midpoint sums.
        const auto train = regular_train(0, interval * (2 * phase + 1) / (2 * phases), interval, 2s);
        std::vector<Event> heard;
        for (const Event& event : train)
            if (event.time < at(lost_from)) heard.push_back(event);
        if (lost_until > lost_from) {
            rate.observe(at(0ms), at(lost_from), heard);
            rate.lose(at(lost_from), at(lost_until));
        }
        heard.clear();
        for (const Event& event : train)
            if (event.time >= at(lost_until)) heard.push_back(event);
        rate.observe(at(lost_until), at(2s), heard);
        const double value = hz(rate, 2s);
        sum += value;
        squares += value * value;
        window_s = rate.at(at(2s)).window_s();
    }
    return {sum / phases, squares / phases - sum / phases * sum / phases, window_s};
}

// Midpoint sums over n phases have an error of (P/(n tau))²/24, 2e-6 at 200 phases and P = 1.6 tau.
TEST(ExponentialRate, OfARegularTrainHasTheMeanAndVarianceOfTheClosedForm) {
    for (const Duration interval : {1ms, 4ms, 16ms, 64ms}) {
        const double interval_s = seconds(interval);
        const double x = interval_s / tau_s;
        const Moments moments = over_phases(interval, 200);
        EXPECT_NEAR(moments.mean_hz, 1 / interval_s, 1e-5 / interval_s);
        const double variance = ((x / 2) / std::tanh(x / 2) - 1) / (interval_s * interval_s);
        // The largest of the phases that is summed is half a part short of the end of the interval, so the
        // variance is that of n equidistant values and not of a uniform one: 1/n² less.
        EXPECT_NEAR(moments.variance_hz2, variance, 1e-4 * variance);
        EXPECT_LE(variance, 1 / (12 * tau_s * tau_s));
        // The window that it claims: a variance of 1/(6 T²).
        EXPECT_NEAR(1 / (6 * moments.window_s * moments.window_s), 1 / (12 * tau_s * tau_s), 1e-9);
    }
}

TEST(ExponentialRate, IsAsCertainAsASlidingWindowOfTheSquareRootOfTwoTimeConstants) {
    ExponentialRate rate({true}, tau, false);
    rate.observe(at(0ms), at(2s), {});
    EXPECT_NEAR(rate.at(at(2s)).window_s(), std::sqrt(2.0) * tau_s, 1e-12);
}

// A spike more or less is told of until half of a window that is as certain is known.
TEST(ExponentialRate, TellsWhatASpikeChangesWhileLessThanHalfIsKnown) {
    int told = 0;
    for (Duration known = 1ms; known <= 100ms; known += 1ms) {
        ExponentialRate rate({true}, tau, false);
        rate.observe(at(0ms), at(known), {});
        const auto counts = rate.at(at(known));
        const bool is_little = counts.window_s() < std::sqrt(0.5) * tau_s;
        EXPECT_EQ(counts.spike_hz(), is_little ? 1 / counts.known_s() : 0) << seconds(known);
        told += is_little;
    }
    EXPECT_GT(told, 10);
    EXPECT_LT(told, 90);
}

// One spike 200 ms ago allows a rate of 5 Hz, beyond the memory of the kernel; who has never fired may be at
// rest.
TEST(ExponentialRate, AllowsARateOnlyToWhoHasFired) {
    ExponentialRate rate({true, true}, tau, true);
    rate.observe(at(0ms), at(300ms), std::vector<Event>{{at(100ms), 0}});
    EXPECT_NEAR(rate.at(at(300ms)).allowed_hz_of(0), 5, 1e-9);
    EXPECT_EQ(rate.at(at(300ms)).allowed_hz_of(1), 0);
}

TEST(ExponentialRate, DecaysAfterTheLastSpike) {
    ExponentialRate rate({true}, tau, false);
    rate.observe(at(0ms), at(1s), regular_train(0, 5ms, 10ms, 1s));
    const double before = hz(rate, 1s);
    for (const Duration silence : {1ms, 40ms, 400ms}) {
        ExponentialRate later = rate;
        later.observe(at(1s), at(1s + silence), {});
        // It began 25 time constants before, so e^-25 of the kernel was not known.
        EXPECT_NEAR(hz(later, 1s + silence), before * std::exp(-seconds(silence) / tau_s), 2e-11 * before);
    }
}

TEST(ExponentialRate, IsOneSpikeOverTheTimeConstantJustAfterALoneSpike) {
    ExponentialRate rate({true}, tau, false);
    rate.observe(at(0s), at(1h), {});
    rate.observe(at(1h), at(1h + 1ns), std::vector<Event>{{at(1h), 0}});
    EXPECT_NEAR(hz(rate, 1h + 1ns), 1 / tau_s, 1e-6) << "an age of 1 ns takes 2.5e-8 of it";
}

TEST(ExponentialRate, IsNotBiasedByALostSpanAndLessCertain) {
    const Duration interval = 7ms;
    const Moments whole = over_phases(interval, 1000);
    for (const auto& [from, until] : {std::pair{1900ms, 1950ms}, {1950ms, 1999ms}, {1980ms, 1985ms}}) {
        const Moments lost = over_phases(interval, 1000, from, until);
        // At each of three boundaries one phase in 1000 may fall on the wrong side: a spike's weight, 1/tau.
        EXPECT_NEAR(lost.mean_hz, 1 / seconds(interval), 3 * 1e-3 * 5 / tau_s);
        EXPECT_LT(lost.window_s, whole.window_s);
    }
}

// The sawteeth of the boundaries are correlated at one rate and uncorrelated on average over rates.
TEST(ExponentialRate, WithALostSpanItVariesAsMuchAsItSaysOnAverageOverRates) {
    double said = 0, found = 0;
    for (Duration interval = 2ms; interval < 4ms; interval += 37us) {
        const Moments moments = over_phases(interval, 100, 1960ms, 1981ms);
        said += 1 / (6 * moments.window_s * moments.window_s);
        found += moments.variance_hz2;
    }
    // 55 rates: a mean of that many products of two sawteeth is good to some tenth.
    EXPECT_NEAR(found / said, 1, 0.15);
}

// Against its definition, over random spans.
TEST(ExponentialRate, AgreesWithSummingOverTheWholePast) {
    const auto stream = random_stream(4, 300, 3);
    ExponentialRate rate({true, false, true}, tau, true);
    std::vector<Event> all;
    std::vector<std::pair<TimePoint, TimePoint>> known;
    TimePoint presumed = scene_start;
    TimePoint end = scene_start;
    for (const Step& step : stream) {
        if (step.lost) {
            rate.lose(step.begin, step.end);
        } else {
            rate.observe(step.begin, step.end, step.events);
            all.insert(all.end(), step.events.begin(), step.events.end());
            known.emplace_back(step.begin, step.end);
        }
        rate.presume_silence(step.presumed);
        presumed = std::max(presumed, step.presumed);
        end = step.end;

        const auto kernel = [&](TimePoint time) { return std::exp(-seconds(step.now - time) / tau_s); };
        double sum = 0, of_2 = 0;
        for (const Event& event : all) {
            sum += event.address != 1 ? kernel(event.time) : 0;
            of_2 += event.address == 2 ? kernel(event.time) : 0;
        }
        double weight = std::max(0.0, kernel(presumed) - kernel(end));
        for (const auto& [from, until] : known) weight += kernel(until) - kernel(from);
        const auto counts = rate.at(step.now);
        // A few hundred roundings of numbers up to 10.
        ASSERT_NEAR(counts.events(), sum, 1e-12);
        ASSERT_NEAR(counts.events_of(2), of_2, 1e-12);
        ASSERT_NEAR(counts.known_s(), weight * tau_s, 1e-14);
    }
}

TEST(ExponentialRate, IsTheSameInPiecesAsAtOnce) {
    const auto train = regular_train(0, 3ms, 7ms, 1s);
    ExponentialRate whole({true}, tau, false);
    whole.observe(at(0ms), at(1s), train);
    ExponentialRate pieces({true}, tau, false);
    auto next = train.begin();
    for (Duration begin = 0ms; begin < 1s; begin += 1ms) {
        const auto from = next;
        while (next != train.end() && next->time < at(begin + 1ms)) ++next;
        pieces.observe(at(begin), at(begin + 1ms), {from, next});
    }
    EXPECT_NEAR(hz(pieces, 1s), hz(whole, 1s), 1e-11) << "a thousand roundings of some 100 Hz";
    EXPECT_NEAR(pieces.at(at(1s)).window_s(), whole.at(at(1s)).window_s(), 1e-14);
}

TEST(ExponentialRate, CountsTwoLostSpansInSuccessionAsOne) {
    ExponentialRate one({true}, tau, false);
    ExponentialRate two({true}, tau, false);
    for (auto* rate : {&one, &two}) rate->observe(at(0ms), at(100ms), {});
    one.lose(at(100ms), at(130ms));
    two.lose(at(100ms), at(115ms));
    two.lose(at(115ms), at(130ms));
    for (auto* rate : {&one, &two}) rate->observe(at(130ms), at(140ms), {});
    EXPECT_NEAR(one.at(at(140ms)).window_s(), two.at(at(140ms)).window_s(), 1e-15);
}

TEST(ExponentialRate, ForgetsALastSpanThatWasLostAfterAll) {
    ExponentialRate whole({true}, tau, false);
    ExponentialRate part({true}, tau, false);
    // All that is known is taken back, and more.
    for (auto* rate : {&whole, &part}) rate->lose(at(0ms), at(50ms));
    whole.observe(at(50ms), at(60ms), {});
    whole.lose(at(40ms), at(70ms));
    EXPECT_EQ(whole.at(at(70ms)).window_s(), 0);
    part.lose(at(50ms), at(70ms));
    for (auto* rate : {&whole, &part}) rate->observe(at(70ms), at(80ms), {});
    EXPECT_NEAR(whole.at(at(80ms)).window_s(), part.at(at(80ms)).window_s(), 1e-15);
}

TEST(ExponentialRate, DoesNotCountEventsOfALostSpan) {
    ExponentialRate rate({true}, tau, false);
    rate.observe(at(0ms), at(100ms), {});
    // The first part of a span is lost, and the second arrives.
    rate.lose(at(100ms), at(105ms));
    rate.observe(at(100ms), at(105ms), std::vector<Event>{{at(104ms), 0}});
    EXPECT_EQ(rate.at(at(105ms)).events(), 0);
    EXPECT_NEAR(rate.at(at(105ms)).known_s(), tau_s * (std::exp(-5.0 / 40) - std::exp(-105.0 / 40)), 1e-15);
}

TEST(ExponentialRate, KnowsLessAndLessAfterTheLastSpanAndAtLastNothing) {
    ExponentialRate rate({true}, tau, false);
    rate.observe(at(0ms), at(1s), regular_train(0, 5ms, 10ms, 1s));
    const double before = hz(rate, 1s);
    const double window_s = rate.at(at(1s)).window_s();
    // The last spans are as before; their weight has fallen, and with it the window.
    EXPECT_NEAR(hz(rate, 1s + tau), before, 1e-12 * before);
    EXPECT_NEAR(rate.at(at(1s + tau)).window_s(), window_s / std::exp(1.0), 1e-12);
    EXPECT_GT(rate.at(at(1s + 20 * tau)).window_s(), 0);
    EXPECT_EQ(rate.at(at(1s + 21 * tau)).window_s(), 0) << "e^-20.7 is the billionth that is negligible";
    EXPECT_EQ(rate.at(at(1h)).window_s(), 0);
}

TEST(ExponentialRate, KnowsNothingBeforeItsStart) {
    ExponentialRate rate({true}, tau, false);
    EXPECT_EQ(rate.at(scene_start).window_s(), 0);
    rate.resume(at(100ms), at(95ms));
    rate.observe(at(95ms), at(105ms), std::vector<Event>{{at(97ms), 0}, {at(102ms), 0}});
    const auto counts = rate.at(at(105ms));
    EXPECT_NEAR(counts.known_s(), tau_s * -std::expm1(-5.0 / 40), 1e-15);
    EXPECT_NEAR(counts.events(), std::exp(-3.0 / 40), 1e-15) << "the event before the start does not count";
}

TEST(ExponentialRate, RefusesATimeConstantOfZero) {
    EXPECT_THROW(ExponentialRate({true}, 0ns, false), ParameterError);
    EXPECT_THROW(ExponentialRate({true}, -1ns, false), ParameterError);
}

}  // namespace
}  // namespace afferent
