// The decoding benchmark's statements about decoders and schemes are right, and the same every time.
#include "bench/decoding_bench.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <utility>

#include "bench/decoding_loss.hpp"
#include "bench/decoding_tables.hpp"
#include "bench/event_packets.hpp"
#include "bench/force_score.hpp"
#include "bench/scheme_map.hpp"
#include "bench/wander_limits.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

const std::vector<Touch>& quick_touches() {
    static const std::vector<Touch> found =
        touches({.examples = AFFERENT_SOURCE_DIR "/examples", .quick = true});
    return found;
}

const Touch& touch(const std::string& name) { return found_or_throw(quick_touches(), name, &Touch::name); }

ForceScore score_of(const Touch& touch, const DecodingCell& cell) {
    return score(follow(touch, cell), Touch::step);
}

DecodingCell events(const char* decoder) { return {"events", decoder, 100us, 5ms}; }

TEST(ForceScore, IsThatOfADelayedAndBiasedForce) {
    // A ramp to 10 N within 0.5 s, held for 2 s; the estimate is 20 ms late and 0.1 N too high.
    std::vector<double> force_n;
    for (int k = 0; k < 2500; ++k) force_n.push_back(std::min(10.0, 0.02 * k));
    FollowedForce followed{force_n, force_n, force_n, {}};
    for (int k = 0; k < 2500; ++k)
        followed.estimates.push_back(
            {.force_n = std::min(10.0, 0.02 * std::max(0, k - 20)) + 0.1, .sigma_n = k < 1250 ? 0.01 : 0.06});
    const ForceScore found = score(std::span(&followed, 1), 1ms);
    EXPECT_NEAR(found.delay_ms, 20, 0.1);
    EXPECT_NEAR(found.hold_bias_n, 0.1, 1e-9);
    EXPECT_NEAR(found.overshoot_n, 0.1, 1e-9);
    EXPECT_NEAR(found.coverage_95.value(), 0.5, 0.01);  // 1.96 · 0.06 N > 0.1 N in the second half
    double squares = 0;
    for (std::size_t k = 0; k < force_n.size(); ++k)
        squares += std::pow(followed.estimates[k].force_n - force_n[k], 2);
    EXPECT_NEAR(found.rms_n, std::sqrt(squares / 2500), 1e-12);
}

TEST(WanderLimits, AreThoseOfTheLiterature) {
    const WanderLimits limits{.n2_per_s = 3};
    // 3/(6 · 10)
    EXPECT_NEAR(limits.event_triggered(10), 0.05, 1e-12);
    EXPECT_NEAR(limits.uniform(10) / limits.event_triggered(10), 5, 1e-12);
    // A code that tells by its bits alone needs 3/ln 2 = 4.33 times the bits of one that tells by time.
    EXPECT_NEAR(limits.causal(10) / limits.event_triggered(10), 3 / std::numbers::ln2, 1e-12);
    EXPECT_NEAR(limits.aged(0.5, 0.01, 0.002), 0.5 + 3 * 0.007, 1e-12);
}

// The same forces reach every scheme: samples of 12 bits at 200 Hz lose nothing but the noise of the sensors
// and 7 ms.
TEST(DecodingBench, FollowsSamplesWithinTheirNoise) {
    const ForceScore found = score_of(touch("grasp-no-hysteresis"), {"raw12", "force_model", {}, 5ms, 1});
    EXPECT_LT(found.rms_n, 0.05);
    EXPECT_LT(std::abs(found.hold_bias_n), 0.005);
    EXPECT_GT(found.coverage_95.value(), 0.9);
}

TEST(DecodingBench, FindsTheFilterBetterThanTheWindow) {
    const auto ratio = [](const Touch& of, const char* decoder) {
        return score_of(of, events(decoder)).rms_n / score_of(of, events("sliding_window")).rms_n;
    };
    EXPECT_LT(ratio(touch("grasp-no-hysteresis"), "filter"), 1 / 8.0);
    EXPECT_LT(ratio(touch("grasp-unmodelled"), "filter"), 1 / 5.0);
    EXPECT_LT(ratio(touch("grasp"), "filter"), 1 / 8.0);
    EXPECT_LT(ratio(touch("paper"), "inversion"), 1 / 4.0);
    for (const char* name : {"grasp", "grasp-no-hysteresis"})
        EXPECT_LT(score_of(touch(name), events("filter")).overshoot_n, 1) << name;
}

TEST(DecodingBench, ChargesWhatPacketsCarry) {
    const LinkActivity& grasp = touch("grasp").activity;
    const auto raw = [&](std::uint32_t every, Duration deadline) {
        return bytes_per_s(grasp, {"raw12", "force_model", {}, deadline, every});
    };
    // 14 bytes of samples in each of 200 packets; in batches the samples remain and the frames get fewer.
    EXPECT_GT(raw(1, 5ms), 200 * 14);
    EXPECT_GT(raw(1, 20ms), 200 * 13.5);
    EXPECT_LT(raw(1, 20ms), raw(1, 5ms) - 150 * 5);
    EXPECT_NEAR(raw(2, 10ms), raw(1, 5ms) / 2, 20);
    EXPECT_LT(bytes_per_s(grasp, {"delta_varint", "force_model", {}, 5ms, 1}), raw(1, 5ms));
    EXPECT_LT(bytes_per_s(grasp, {"send_on_delta", "force_model", {}, 5ms, 1, 0.05}),
              bytes_per_s(grasp, {"send_on_delta", "force_model", {}, 5ms, 1, 0.002}));
    EXPECT_LT(bytes_per_s(grasp, {"events", "filter", 1ms, 5ms}),
              bytes_per_s(grasp, {"events", "filter", 10us, 5ms}));
}

// The other end is told of each event once, within the tolerance of when it came, and at the latest with the
// heartbeat.
TEST(DecodingBench, TellsPredictedEventsWithinTheirTolerance) {
    const LinkActivity& grasp = touch("grasp").activity;
    for (const Duration tolerance : {Duration(0us), Duration(500us), Duration(2ms)}) {
        std::vector<Event> told;
        TimePoint known = scene_start;
        for (const ToldSpan& span : told_spans(grasp, event_layout(grasp, 100us, 5ms, tolerance))) {
            EXPECT_EQ(span.begin, known);
            EXPECT_GE(span.closes, span.end);
            EXPECT_LE(span.closes - span.begin, link_heartbeat);
            known = span.end;
            told.insert(told.end(), span.events.begin(), span.events.end());
        }
        EXPECT_EQ(known, scene_start + grasp.duration);
        std::vector<Event> sent = grasp.events;
        const auto by_address = [](const Event& event) { return std::pair(event.address, event.time); };
        std::ranges::sort(sent, {}, by_address);
        std::ranges::sort(told, {}, by_address);
        ASSERT_EQ(told.size(), sent.size());
        for (std::size_t i = 0; i < sent.size(); ++i) {
            ASSERT_EQ(told[i].address, sent[i].address);
            const Duration ticked = (sent[i].time - scene_start) / Duration(100us) * Duration(100us);
            EXPECT_LE(std::chrono::abs(told[i].time - scene_start - ticked), tolerance);
        }
    }
}

TEST(DecodingBench, DecodesPredictedEventsNearlyAsWellForFewerBytes) {
    const DecodingCell rice = events("filter");
    DecodingCell exact = rice;
    exact.scheme = "predicted";
    exact.tolerance = 0us;
    EXPECT_EQ(told_alike(exact), rice);
    DecodingCell within = exact;
    within.tolerance = 500us;
    EXPECT_EQ(told_alike(within), within);
    const LinkActivity& grasp = touch("grasp").activity;
    EXPECT_LT(bytes_per_s(grasp, exact), bytes_per_s(grasp, rice));
    EXPECT_LT(bytes_per_s(grasp, within), 0.6 * bytes_per_s(grasp, rice));
    EXPECT_LT(score_of(touch("grasp"), within).rms_n, 1.2 * score_of(touch("grasp"), rice).rms_n);
}

// The bytes grow with the activity, and the cheapest scheme of a cell is the cheapest of those that it lists.
TEST(SchemeMap, NamesTheFewestBytes) {
    const Scene grasp = Scene::from_file(AFFERENT_SOURCE_DIR "/examples/grasp.txtpb");
    const std::vector<MapCell> map = map_schemes(grasp, true, [](double) {});
    ASSERT_EQ(map.size(), 8U);
    const auto cost = [](const MapCell& cell, const std::string& scheme) {
        return found_or_throw(cell.costs, scheme, &MapCell::Cost::scheme).bytes_per_s;
    };
    int compared = 0;
    for (const MapCell& cell : map) {
        ASSERT_FALSE(cell.costs.empty());
        ASSERT_NE(cell.cheapest(), nullptr);
        for (const auto& [scheme, bytes] : cell.costs) EXPECT_LE(cell.cheapest()->bytes_per_s, bytes);
        // Untouched skin costs samples as much as touched skin, and events nothing.
        if (cell.elements == 1000) {
            const auto all = std::ranges::find_if(map, [&](const MapCell& other) {
                return other.elements == 1000 && other.activity == 1 &&
                       other.allowed_delay == cell.allowed_delay;
            });
            ASSERT_NE(all, map.end());
            EXPECT_NEAR(cost(cell, "raw12"), cost(*all, "raw12"), 1);
            if (cell.activity < 1) {
                EXPECT_LT(cost(cell, "events"), cost(*all, "events") / 5);
                EXPECT_LT(cost(cell, "predicted"), cost(cell, "events"));
                ++compared;
            }
        }
    }
    EXPECT_GE(compared, 1);
}

TEST(DecodingBench, FindsNoDecoderMuchWorseWithATenthOfThePacketsLost) {
    const std::vector<LossRow> rows =
        measure_loss({touch("grasp"), touch("grasp-no-hysteresis")}, [](double) {});
    ASSERT_EQ(rows.size(), 2 * 5U);
    EXPECT_EQ(std::ranges::count(rows, "filter", &LossRow::decoder), 2);
    for (const LossRow& row : rows) {
        EXPECT_GT(row.ratio(), 1) << row.scene << row.decoder;
        EXPECT_LT(row.ratio(), 2) << row.scene << row.decoder;
        if (row.decoder != "filter") continue;
        EXPECT_GT(row.coverage_95, 0.9) << row.scene;
    }
}

TEST(DecodingBench, IsTheSameEveryTime) {
    for (const DecodingCell& cell :
         {events("filter"), DecodingCell{"send_on_delta", "force_model", {}, 5ms, 1, 0.01}}) {
        const auto one = follow(touch("paper"), cell);
        const auto other = follow(touch("paper"), cell);
        EXPECT_GT(one.at(0).estimates.size(), 1000U);
        EXPECT_EQ(one.at(0).estimates, other.at(0).estimates);
    }
}

TEST(DecodingBench, WritesItsColumns) {
    const std::filesystem::path folder = testing::TempDir() + "decoding";
    DecodingRow row{.touch = &touch("paper"), .cell = events("filter")};
    row.score.coverage_95 = 0.95;
    write_decoding({row}, folder);
    std::ifstream file(folder / "decoding.csv");
    std::string line;
    std::getline(file, line);
    EXPECT_EQ(
        line,
        "scene,elements,scheme,decoder,tick_us,deadline_ms,bytes_per_s,rms_n,rms_sensed_n,p95_n,hold_bias_n,"
        "overshoot_n,delay_ms,coverage_95,delta,dead_band,tolerance_us");
    std::getline(file, line);
    EXPECT_EQ(line, "paper,1,events,filter,100,5,0,0,0,0,0,0,0,0.95,,,");
}

}  // namespace
}  // namespace afferent
