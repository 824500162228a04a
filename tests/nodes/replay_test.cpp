// A replay gives the results of the recorded hand.
#include "afferent/nodes/replay.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "afferent/nodes/run.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

const std::string grasp = R"(duration_s: 4 seed: 3
    hand { user { close_at_s: 0.2 } object { distance_mm: 5 } } )";
const std::string lossy =
    "channel { loss: 0.2 corrupt: 0.1 duplicate: 0.1 latency_ms: 4 jitter_ms: 30 reorder: 0.1 }";

// The numbers of a step, to the bit.
using Told = std::vector<double>;
Told told(const ControllerStep& step) {
    return {seconds(step.time),    step.true_force_n.value_or(-1),
            step.estimate.force_n, step.estimate.sigma_n,
            step.estimate.rate_hz, step.gain,
            step.closing_counts,   step.effort.closing,
            step.effort.opening,   step.command};
}

class Replays : public testing::Test {
  protected:
    Replays() : file_(fs::temp_directory_path() / ("afferent-" + std::to_string(getpid()) + ".replay")) {}
    ~Replays() override { fs::remove(file_); }

    proto::Hello hello(const Plan& plan) const {
        proto::Hello hello;
        hello.set_scene_fingerprint(plan.scene.fingerprint());
        return hello;
    }

    std::vector<Told> record(const std::string& text, TimePoint until = TimePoint::max()) {
        const Plan plan = make_plan(Scene::from_text(text, "scene", AFFERENT_SOURCE_DIR "/examples"));
        std::vector<Told> steps;
        const auto run = value_or_throw(afferent::Run::open(
            plan, {.step = [&](const ControllerStep& step) { steps.push_back(told(step)); }}));
        value_or_throw(run->record(file_, hello(plan)));
        while (!run->done() && run->next() < until) value_or_throw(run->do_next());
        run->finish(std::min(until, plan.end()));
        counts_ = run->received();
        value_or_throw(run->close());
        EXPECT_FALSE(steps.empty());
        return steps;
    }

    std::vector<Told> replay(TimePoint from = scene_start) {
        std::vector<Told> steps;
        const auto replay = value_or_throw(
            Replay::open(file_, {.gap = [&](const TimeSpan&) { ++gaps_; },
                                 .step = [&](const ControllerStep& step) { steps.push_back(told(step)); }}));
        if (from != scene_start) value_or_throw(replay->begin_from(from));
        while (const auto next = value_or_throw(replay->next())) {
            EXPECT_GE(seconds(*next), seconds(from));
            replay->step();
        }
        replayed_ = replay->counts();
        return steps;
    }

    std::string refusal() {
        auto opened = Replay::open(file_, {});
        if (!opened) return opened.error().text;
        for (;;) {
            const auto next = opened.value()->next();
            if (!next) return next.error().text;
            if (!next.value()) return "";
            opened.value()->step();
        }
    }

    fs::path file_;
    PacketCounts counts_;
    ReplayCounts replayed_;
    std::uint64_t gaps_ = 0;
};

TEST_F(Replays, OfAPlainLinkAreEqual) {
    const auto steps = record(grasp + "link { tcp {} }");
    EXPECT_EQ(steps.size(), 4000U);
    EXPECT_EQ(replay(), steps);
    EXPECT_EQ(replayed_.events, counts_.events);
    EXPECT_EQ(replayed_.late, 0U);
}

TEST_F(Replays, OfALinkThatLosesDelaysAndReordersAreEqual) {
    const auto steps = record(grasp + "link { tcp {} " + lossy + " }");
    EXPECT_EQ(replay(), steps);
    EXPECT_EQ(replayed_.events, counts_.events);
    EXPECT_EQ(replayed_.gaps, counts_.gaps);
    EXPECT_EQ(gaps_, counts_.gaps);
    EXPECT_EQ(replayed_.lost_events, counts_.lost_events);
    EXPECT_EQ(replayed_.late, counts_.late);
    EXPECT_EQ(replayed_.out_of_order, counts_.out_of_order);
    EXPECT_GT(counts_.late, 100U);
    EXPECT_GT(counts_.gaps, 10U);
}

TEST_F(Replays, OfALinkThatIsCutAreEqual) {
    const auto steps = record(grasp + "link { tcp {} channel { loss: 0.97 } }");
    EXPECT_EQ(replay(), steps);
    EXPECT_EQ(replayed_.safe_states, 1U);
    EXPECT_GT(replayed_.freezes, 0U);
}

TEST_F(Replays, NeedNoTables) {
    for (const char* link : {"", "channel { latency_ms: 9 jitter_ms: 5 }"}) {
        const auto steps = record(
            "duration_s: 8 source { table { path: 'data/grip.csv' column: 'force_n' } } "
            "hand { emg_table { path: 'data/emg.csv' } } link { tcp {} " +
            std::string(link) + " }");
        EXPECT_EQ(replay(), steps);
    }
}

TEST_F(Replays, KnowTheTrueForceOfAProfile) {
    const auto steps = record(
        "duration_s: 2 source { profile { point { time_s: 0 force_n: 0 } point { time_s: 1 force_n: 9 } } } "
        "link { tcp {} }");
    EXPECT_EQ(replay(), steps);
}

TEST_F(Replays, ThatBeginLaterGoOnAsIfTheyHadNot) {
    for (const std::string& scene :
         {grasp + "link { tcp {} }", grasp + "link { tcp {} " + lossy + " }",
          grasp + "link { tcp {} delivery_ms: 40 " + lossy + " } decoder { window_ms: 700 }",
          std::string("duration_s: 4 source { table { path: 'data/grip.csv' column: 'force_n' } } "
                      "hand { emg_table { path: 'data/emg.csv' } } link { tcp {} }")}) {
        const auto steps = record(scene);
        for (const Duration from : {Duration(1ns), Duration(600ms), Duration(2s), Duration(2s + 1ns),
                                    Duration(3s + 777'700us), Duration(4s)}) {
            const auto begin = std::find_if(steps.begin(), steps.end(), [&](const Told& step) {
                return step[0] >= seconds(scene_start + from);
            });
            EXPECT_EQ(replay(scene_start + from), std::vector<Told>(begin, steps.end())) << seconds(from);
        }
    }
}

TEST_F(Replays, EndWhereTheRunWasBrokenOff) {
    const auto steps = record(grasp + "link { tcp {} }", scene_start + 1234ms);
    EXPECT_EQ(steps.size(), 1234U);
    EXPECT_EQ(replay(), steps);
}

TEST_F(Replays, OfAKilledRunHaveWhatItHad) {
    const auto steps = record(grasp + "link { tcp {} " + lossy + " }");
    const auto size = fs::file_size(file_);
    std::size_t most = 0;
    for (const double part : {0.999, 0.9, 0.7, 0.4}) {
        fs::resize_file(file_, static_cast<std::uintmax_t>(part * static_cast<double>(size)));
        const auto left = replay();
        ASSERT_LE(left.size(), steps.size());
        EXPECT_TRUE(std::equal(left.begin(), left.end() - std::min<std::ptrdiff_t>(60, std::ssize(left)),
                               steps.begin()));
        EXPECT_TRUE(most == 0 || left.size() < most);
        most = left.size();
        EXPECT_GT(most, 1000U);
    }
}

TEST_F(Replays, TellTheSceneTheyHold) {
    record(
        "duration_s: 0.2 name: 'a \"name\"' seed: 18446744073709551615 link { tcp {} tick_us: 12.5 } "
        "decoder { window_ms: 60.123456789012345 } gain { onset_n: 0.1 }");
    const auto replay = Replay::open(file_, {});
    ASSERT_TRUE(replay) << replay.error().text;
    const Plan& plan = replay.value()->plan();
    EXPECT_EQ(plan.scene.name, "a \"name\"");
    EXPECT_EQ(plan.scene.seed, ~std::uint64_t{0});
    EXPECT_EQ(std::get<scene::SlidingWindow>(plan.scene.decoder.kind).window_ms, 60.123456789012345);
    EXPECT_EQ(Scene::from_text(plan.scene.text()).fingerprint(), plan.scene.fingerprint());
}

// Entries that no recording of ours has.
TEST_F(Replays, RefuseWhatCannotBe) {
    const Plan plan = make_plan(Scene::from_text(grasp + "link { tcp {} }"));
    const auto refused = [&](const auto& fill) {
        proto::RecordingHead head;
        head.set_scene(plan.scene.text());
        head.set_has_steps(true);
        auto writer = value_or_throw(RecordingWriter::create(file_, head));
        proto::Entry entry;
        fill(entry);
        writer.write(entry);
        value_or_throw(writer.close());
        return refusal();
    };
    EXPECT_NE(refused([](auto& e) { e.mutable_head(); }).find("second head"), std::string::npos);
    EXPECT_NE(refused([](auto& e) { e.mutable_emg(); }).find("EMG"), std::string::npos);
    EXPECT_NE(refused([](auto& e) { e.mutable_link()->set_position(1); }).find("before any hello"),
              std::string::npos);
    EXPECT_NE(refused([](auto& e) { e.mutable_link()->mutable_hello(); }).find("another scene"),
              std::string::npos);
    EXPECT_NE(refused([](auto& e) { e.mutable_begin()->set_time_ns(-1); }).find("outside of its scene"),
              std::string::npos);
    EXPECT_EQ(refused([](auto& e) { e.set_step(~std::uint64_t{0}); }), "");
}

}  // namespace
}  // namespace afferent
