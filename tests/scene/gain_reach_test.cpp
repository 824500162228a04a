// A scene whose gain cannot reach 0 at its limit is refused, with the numbers.
#include "afferent/decoders/gain_reach.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

// One element without adaptation; its rate is that of the tuning at every force in between, nearly.
std::string one(const std::string& decoder, const std::string& rest = "") {
    return "patch { name: 'a' elements: 1 sensor { full_scale_n: 25 } neuron { delta_g: 0 } } decoder { " +
           decoder + " } " + rest;
}

Plan accepted(const std::string& text) {
    return make_plan(Scene::from_text(text + " gain { accept_unreachable_limit: true }"));
}

GainReach reach_of(const std::string& text) {
    return gain_reach(accepted(text).controller.value().gain_loop());
}

std::string refusal_of(const std::string& text) {
    try {
        Scene::from_text(text).check();
    } catch (const SceneError& error) {
        return error.what();
    }
    return "";
}

double steady_hz(const std::string& text, double grip_n) {
    return accepted(text).controller.value().afferents.groups.at(0).rate_hz(RateKind::steady, grip_n);
}

TEST(GainReach, WantsSensorsThatReadMoreThanTheLimitByHowWellTheyAreKnown) {
    const std::string text =
        one("interval {}", "uncertainty { gain: 0.03 common_gain: 0.04 hysteresis: 0 } ");
    const GainReach reach = reach_of(text);
    EXPECT_DOUBLE_EQ(reach.limit_n, 10);
    // The last fiftieth of a sensor's range tells nothing.
    EXPECT_DOUBLE_EQ(reach.sensed_n, 0.98 * 25);
    EXPECT_DOUBLE_EQ(reach.wanted_n, 10 * (1 + 2 * 0.05));
    const auto with = [&](double full_scale_n) {
        std::string other = text;
        return other.replace(other.find("25"), 2, std::to_string(full_scale_n));
    };
    EXPECT_EQ(refusal_of(with(11.3)), "");
    EXPECT_NE(refusal_of(with(11.1))
                  .find("gain.limit_n is 10 N: the sensors read 10.9 N at most, and as well as "
                        "they are known they have to read 11 N"),
              std::string::npos)
        << refusal_of(with(11.1));
    EXPECT_NE(refusal_of(with(9.6)).find("gain.limit_n is 10 N: the sensors read 9.41 N at most"),
              std::string::npos);
}

// Nine elements know the grip better than one does, but no better than what they have in common.
TEST(GainReach, AveragesGainsOfElementsAndNotWhatTheyHaveInCommon) {
    const std::string known =
        "uncertainty { gain: 0.09 common_gain: 0.04 hysteresis: 0 } decoder { interval {} }";
    EXPECT_DOUBLE_EQ(reach_of(known).wanted_n, 10 * (1 + 2 * std::hypot(0.03, 0.04)));
}

TEST(GainReach, TakesTheLastElementForTheFilterAndTheMeanForOthers) {
    const std::string shares =
        "patch { name: 'a' elements: 2 share: [0.8, 0.2] sensor { full_scale_n: 16 } } ";
    EXPECT_DOUBLE_EQ(reach_of(shares + "decoder { filter {} }").sensed_n, 0.98 * 80);
    EXPECT_DOUBLE_EQ(reach_of(shares + "decoder { inversion {} }").sensed_n, 0.98 * (0.8 * 20 + 0.2 * 80));
}

// A window holds floor(rT) spikes at least, and the limit's rate asks for ceil(rT).
TEST(GainReach, ClosesAWindowAtTheNextWholeSpike) {
    for (const double window_ms : {33.0, 70.0, 150.0}) {
        const std::string text = one("window_ms: " + std::to_string(window_ms));
        const GainReach reach = reach_of(text);
        const double window_s = window_ms / 1000;
        ASSERT_TRUE(reach.closes_n);
        const double spikes = std::ceil(steady_hz(text, 10) * window_s);
        ASSERT_GE(spikes, 1);
        // Within half a hundredth, to which the force is sought.
        EXPECT_GE(steady_hz(text, *reach.closes_n) * window_s, spikes * (1 - 1e-6));
        EXPECT_LT(steady_hz(text, *reach.closes_n / 1.0051) * window_s, spikes);
    }
}

// Just before a spike the kernel's rate is 1/(tau (e^(P/tau) − 1)); it has to be that of the limit.
TEST(GainReach, ClosesAKernelWhereItsTroughsAreAtTheLimit) {
    const std::string text = one("exponential { time_constant_ms: 40 }");
    const GainReach reach = reach_of(text);
    ASSERT_TRUE(reach.closes_n);
    const double rate_hz = 1 / (0.04 * std::log1p(1 / (0.04 * steady_hz(text, 10))));
    EXPECT_NEAR(steady_hz(text, *reach.closes_n), rate_hz, 5e-3 * rate_hz);
}

TEST(GainReach, ClosesIntervalsAndModelsAtTheLimit) {
    for (const char* decoder : {"interval {}", "inversion {}", "filter {}"})
        EXPECT_NEAR(reach_of(one(decoder)).closes_n.value_or(0), 10, 0.05) << decoder;
}

TEST(GainReach, RefusesWindowsThatAreEmptyMostOfTheTimeWithTheNumbers) {
    const std::string slow =
        "patch { name: 'a' elements: 1 sensor { full_scale_n: 25 } neuron { tau_g_ms: 500 "
        "tuning { rate: ONSET rate_hz: 30 } } } ";
    const std::string text = refusal_of(slow);
    EXPECT_NE(text.find("gain.limit_n is 10 N: there an afferent fires "), std::string::npos) << text;
    EXPECT_NE(text.find(" times a second once adapted, and a window of 60 ms is empty "), std::string::npos)
        << text;
    EXPECT_NE(text.find("accept_unreachable_limit"), std::string::npos);
    const GainReach reach = reach_of(slow);
    EXPECT_LT(reach.rate_hz * 0.06, 1);
    EXPECT_FALSE(reach.closes_at_limit());
    // Nor may the filter wait for so long; an interval may.
    EXPECT_LT(reach.rate_hz, 3);
    EXPECT_GT(reach.rate_hz, 1);
    EXPECT_NE(refusal_of(slow + "decoder { filter {} }").find("a force may rise unnoticed for "),
              std::string::npos);
    EXPECT_EQ(refusal_of(slow + "decoder { interval {} }"), "");
    EXPECT_EQ(refusal_of(slow + "gain { accept_unreachable_limit: true }"), "");
}

// An upper bound closes earlier than the estimate.
TEST(GainReach, GoesByTheBoundThatTheGainGoesBy) {
    const std::string text = one("exponential { time_constant_ms: 40 }");
    Scene scene = accepted(text).scene;
    scene.gain.upper_bound_sigmas = 2;
    EXPECT_LT(gain_reach(make_plan(scene).controller.value().gain_loop()).closes_n.value(),
              reach_of(text).closes_n.value());
}

TEST(GainReach, IsAskedForWhereAHandMoves) {
    const std::string low = "patch { name: 'a' elements: 1 sensor { full_scale_n: 5 } } ";
    EXPECT_NE(refusal_of(low), "") << "a simulated hand";
    const std::string recorded = low + "source { profile { point { force_n: 3 } } } ";
    EXPECT_EQ(refusal_of(recorded), "") << "nothing moves";
    EXPECT_NE(refusal_of(recorded + "output { command_file { path: 'c.csv' } }"), "") << "commands";
    const Scene scene = Scene::from_text(recorded);
    EXPECT_THROW((void)make_plan(scene, Commands::wanted), SceneError) << "a real hand";
    EXPECT_TRUE(make_plan(scene, Commands::recorded).controller) << "it has moved already";
}

TEST(GainReach, IsSaidByThePlanOfASceneThatAcceptsIt) {
    const Plan plan =
        make_plan(Scene::from_text("patch { name: 'a' elements: 1 sensor { full_scale_n: 5 } } gain { "
                                   "accept_unreachable_limit: true }"));
    const auto part = std::ranges::find(plan.items, "gain of 0 at the limit", &PlanItem::name);
    ASSERT_NE(part, plan.items.end());
    EXPECT_FALSE(part->built);
    EXPECT_NE(part->reason.find("limit_n is 10 N: the sensors read 4.9 N at most"), std::string::npos)
        << part->reason;
}

}  // namespace
}  // namespace afferent
