// A replay gives the results of the recorded hand.
#include "afferent/nodes/replay.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
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

    // A recording of these entries, which may be such as no recording of ours has.
    void write(const std::vector<proto::Entry>& entries) {
        static const std::string scene =
            Scene::from_text(grasp + "link { tcp {} } decoder { window_ms: 60 }").text();
        write(entries, scene);
    }
    void write(const std::vector<proto::Entry>& entries, const std::string& scene) {
        proto::RecordingHead head;
        head.set_scene(scene);
        head.set_has_steps(true);
        auto writer = value_or_throw(RecordingWriter::create(file_, head));
        for (const proto::Entry& entry : entries) writer.write(entry);
        value_or_throw(writer.close());
    }

    // What a replay that begins at this time is refused for.
    std::string refusal_from(TimePoint time) {
        const Result<void> begun = value_or_throw(Replay::open(file_, {}))->begin_from(time);
        return begun ? "" : begun.error().text;
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

// From any time on: what was foreseen there follows from all packets before.
TEST_F(Replays, OfALinkThatPredictsSpikesAreEqual) {
    for (const char* const tolerance : {"", "timing_tolerance_us: 500"}) {
        const auto steps =
            record(grasp + "link { tcp {} encoding: PREDICTED " + tolerance + " } decoder { filter {} }");
        EXPECT_EQ(replay(), steps);
        EXPECT_EQ(replayed_.events, counts_.events);
        EXPECT_EQ(replayed_.gaps, 0U);
        EXPECT_EQ(counts_.refused, 0U);
        for (const Duration from : {Duration(600ms), Duration(2s)}) {
            const auto begin = std::find_if(steps.begin(), steps.end(), [from](const Told& step) {
                return step[0] >= seconds(scene_start + from);
            });
            EXPECT_EQ(replay(scene_start + from), std::vector<Told>(begin, steps.end())) << seconds(from);
        }
    }
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

TEST_F(Replays, OfPredictedSpikesThatWereLostAreEqual) {
    const auto steps = record(grasp + "link { udp {} encoding: PREDICTED timing_tolerance_us: 500 " + lossy +
                              " } decoder { filter {} }");
    EXPECT_EQ(replay(), steps);
    EXPECT_EQ(replayed_.events, counts_.events);
    EXPECT_EQ(replayed_.gaps, counts_.gaps);
    EXPECT_EQ(replayed_.lost_events, counts_.lost_events);
    EXPECT_EQ(counts_.refused, 0U);
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

TEST_F(Replays, TellTheShareOfTheTrueForceThatEachPartHas) {
    record(
        "duration_s: 0.1 patch { name: 'a' elements: 2 share: [0.5, 0.25] } decoder { parts: ELEMENTS } "
        "source { profile { point { force_n: 8 } } } link { tcp {} }");
    int steps = 0;
    const auto replay = value_or_throw(Replay::open(file_, {.step = [&](const ControllerStep& step) {
                                                        ++steps;
                                                        ASSERT_EQ(step.parts.size(), 2U);
                                                        EXPECT_EQ(step.parts[0].true_force_n, 4);
                                                        EXPECT_EQ(step.parts[1].true_force_n, 2);
                                                    }}));
    while (value_or_throw(replay->next())) replay->step();
    EXPECT_EQ(steps, 100);
}

// Columns of a table whose ratio changes, stays while the force changes, and is that of the shares for a
// while.
TEST_F(Replays, TellWhatEachPartFeltWhereItIsNotItsShare) {
    const fs::path table = fs::temp_directory_path() / ("afferent-" + std::to_string(getpid()) + ".csv");
    std::ofstream(table)
        << "time_s,a_n,b_n\n0,3,1\n0.02,3,1\n0.04,1,3\n0.06,2,2\n0.08,2,2\n0.1,6,2\n0.12,6,2\n";
    const auto parts_of = [](const ControllerStep& step) {
        return std::array{step.parts.at(0).true_force_n.value_or(-1),
                          step.parts.at(1).true_force_n.value_or(-1)};
    };
    std::vector<std::array<double, 2>> ran;
    const Plan plan = make_plan(
        Scene::from_text("duration_s: 0.12 patch { name: 'a' elements: 1 } patch { name: 'b' elements: 1 } "
                         "decoder { parts: PATCHES } link { tcp {} } source { table { path: '" +
                         table.string() + "' } }"));
    const auto run = value_or_throw(afferent::Run::open(
        plan, {.step = [&](const ControllerStep& step) { ran.push_back(parts_of(step)); }}));
    value_or_throw(run->record(file_, hello(plan)));
    while (!run->done()) value_or_throw(run->do_next());
    run->finish(plan.end());
    value_or_throw(run->close());
    ASSERT_EQ(ran.size(), 120U);
    EXPECT_EQ(ran[10], (std::array{3.0, 1.0}));
    EXPECT_EQ(ran[50], (std::array{1.5, 2.5}));
    EXPECT_EQ(ran[70], (std::array{2.0, 2.0}));
    EXPECT_EQ(ran[110], (std::array{6.0, 2.0}));

    std::vector<std::array<double, 2>> replayed;
    const auto replay = value_or_throw(Replay::open(
        file_, {.step = [&](const ControllerStep& step) { replayed.push_back(parts_of(step)); }}));
    while (value_or_throw(replay->next())) replay->step();
    EXPECT_EQ(replayed, ran);
    fs::remove(table);
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

// It knows where in the session it is, and how many events were before that.
TEST_F(Replays, ThatBeginLaterMissNothingOfWhatHasCome) {
    record(grasp + "link { tcp {} }");
    replay(scene_start + 3s);
    EXPECT_GT(replayed_.events, 0U);
    EXPECT_LT(replayed_.events, counts_.events);
    EXPECT_EQ(replayed_.gaps, 0U);
    EXPECT_EQ(replayed_.lost_events, 0U);
    EXPECT_EQ(replayed_.refused + replayed_.out_of_order, 0U);
}

// Marks are for those that begin later.
TEST_F(Replays, ThatBeginAtTheBeginningComputeWhatMarksSay) {
    const auto steps = record(grasp + "link { tcp {} }");
    std::vector<proto::Entry> entries;
    int marks = 0;
    auto recording = value_or_throw(RecordingReader::open(file_));
    for (proto::Entry entry; value_or_throw(recording.next(entry)); entries.push_back(entry)) {
        if (entry.link().has_hello() || entry.has_begin()) {
            EXPECT_EQ(entry.step(), 0U);
        }
        if (!entry.has_mark()) continue;
        EXPECT_EQ(entry.mark().first_step(), 0U);
        entry.mutable_mark()->set_force_n(99);
        ++marks;
    }
    EXPECT_EQ(marks, 4);
    write(entries, recording.head().scene());
    EXPECT_EQ(replay(), steps);
}

// The mark of a hand that has done the steps of so many seconds, a thousand in each.
proto::Entry mark_after(int whole_s) {
    proto::Entry entry;
    entry.set_step(1000U * static_cast<unsigned>(whole_s) + 1);
    entry.mutable_mark()->set_time_ns(Duration(std::chrono::seconds(whole_s)).count());
    entry.mutable_mark()->set_heard_until_ns(entry.mark().time_ns());
    return entry;
}

TEST_F(Replays, ThatBeginLaterReadFromAMark) {
    proto::Entry end;
    end.set_step(4000);
    end.mutable_end();
    write({mark_after(1), mark_after(3), end});
    const auto replay = value_or_throw(Replay::open(file_, {}));
    value_or_throw(replay->begin_from(scene_start + 3500ms));
    EXPECT_EQ(value_or_throw(replay->next()), scene_start + 3500ms);
    EXPECT_EQ(replay->counts().sessions, 1U);
}

TEST_F(Replays, ThatBeginLaterRefuseAMarkOfNoTimeOfTheScene) {
    // The first of two is where the replay begins to read; the scene has four seconds.
    const auto refused = [&](const proto::Entry& first) {
        write({first, mark_after(8)});
        const std::string refusal = refusal_from(scene_start + 9s);
        EXPECT_TRUE(refusal.empty() || refusal.ends_with(": a mark is of no time of the scene")) << refusal;
        return !refusal.empty();
    };
    proto::Entry entry = mark_after(5);
    entry.mutable_mark()->set_heard_until_ns(0);
    EXPECT_TRUE(refused(entry));
    entry = mark_after(4);
    EXPECT_FALSE(refused(entry));
    entry.mutable_mark()->set_heard_until_ns(Duration(4s + 1ns).count());
    EXPECT_TRUE(refused(entry));
    entry.mutable_mark()->set_heard_until_ns(-1);
    EXPECT_TRUE(refused(entry));
    entry = mark_after(4);
    entry.mutable_mark()->set_presumes_from_ns(Duration(14s).count());
    EXPECT_FALSE(refused(entry));
    entry.mutable_mark()->set_presumes_from_ns(Duration(14s + 1ns).count());
    EXPECT_TRUE(refused(entry)) << "later than after a packet lost just now";
    entry.mutable_mark()->set_presumes_from_ns(-1);
    EXPECT_TRUE(refused(entry));
    entry = mark_after(4);
    entry.mutable_mark()->set_first_step(4000);
    EXPECT_FALSE(refused(entry));
    entry.mutable_mark()->set_first_step(4001);
    EXPECT_TRUE(refused(entry));
    entry = mark_after(4);
    entry.set_step(4002);
    EXPECT_TRUE(refused(entry));
    entry.clear_step();
    EXPECT_TRUE(refused(entry));
}

TEST_F(Replays, ThatBeginLaterRefuseADamagedIndex) {
    write({mark_after(1), mark_after(2)});
    // Sixteen bytes follow the index.
    std::fstream file(file_, std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(-17, std::ios::end);
    const int last = file.get();
    file.seekp(-17, std::ios::end);
    file.put(static_cast<char>(last ^ 1));
    file.close();
    EXPECT_NE(refusal_from(scene_start + 3s), "");
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

TEST_F(Replays, RefuseWhatCannotBe) {
    const auto refused = [&](const auto& fill) {
        proto::Entry entry;
        fill(entry);
        write({entry});
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
    // Once there is a session.
    const auto refused_bye = [&](std::int64_t time_ns) {
        proto::Entry begin, bye;
        const Plan plan = value_or_throw(Replay::open(file_, {}))->plan();
        *begin.mutable_link()->mutable_hello() = hello(plan);
        bye.mutable_link()->mutable_bye()->set_time_ns(time_ns);
        write({begin, bye});
        return refusal();
    };
    EXPECT_EQ(refused_bye(0), "");
    EXPECT_NE(refused_bye(-1).find("of no time"), std::string::npos);
    EXPECT_NE(refused_bye(std::int64_t{1} << 62).find("of no time"), std::string::npos);
}

// The recorded hand took no packet of a session before it began anew with it.
TEST_F(Replays, GiveTheHandNothingOfASessionBeforeItBegins) {
    write({});
    const Plan plan = value_or_throw(Replay::open(file_, {}))->plan();
    proto::Entry first, session, packet, anew, end;
    first.set_step(0);
    first.mutable_begin()->set_new_hand(true);
    session.set_step(1);
    *session.mutable_link()->mutable_hello() = hello(plan);
    anew.set_step(3);
    anew.mutable_begin()->set_time_ns(Duration(3ms).count());
    end.set_step(40);
    end.mutable_end();
    Packetizer packetizer(packet_layout(plan));
    packetizer.finish(scene_start + 5ms, [&](const proto::Envelope& one) { *packet.mutable_link() = one; });
    for (const bool begun : {false, true}) {
        packet.set_step(begun ? 4 : 2);
        write(begun ? std::vector{first, session, anew, packet, end}
                    : std::vector{first, session, packet, anew, end});
        EXPECT_EQ(replay().size(), 40U);
        EXPECT_EQ(replayed_.packets, 1U);
        EXPECT_EQ(replayed_.late, begun ? 1U : 0U);
    }
}

TEST_F(Replays, RefuseEmgThatCannotBe) {
    const std::string scene =
        Scene::from_text(
            "duration_s: 4 source { table { path: 'data/grip.csv' column: 'force_n' } } "
            "hand { emg_table { path: 'data/emg.csv' } } link { tcp {} }",
            "scene", AFFERENT_SOURCE_DIR "/examples")
            .text();
    const auto refused = [&](const std::vector<std::int64_t>& gaps_ns, double counts = 2048) {
        proto::Entry entry;
        for (const std::int64_t gap_ns : gaps_ns) {
            entry.mutable_emg()->add_gap_ns(gap_ns);
            entry.mutable_emg()->add_counts(counts);
        }
        write({entry}, scene);
        return refusal().find("has EMG that cannot be") != std::string::npos;
    };
    EXPECT_FALSE(refused({0, 1'000'000, 0, 1'000'000})) << "two of one time";
    EXPECT_FALSE(refused({-1'000'000, 1'000'000})) << "the table may begin before the scene";
    EXPECT_TRUE(refused({0, -1}));
    EXPECT_TRUE(refused({(std::int64_t{1} << 61) + 1}));
    EXPECT_TRUE(refused({-(std::int64_t{1} << 61) - 1}));
    EXPECT_FALSE(refused({std::int64_t{1} << 61, 1}));
    EXPECT_TRUE(refused({std::int64_t{1} << 61, 1, 1})) << "no time is later";
    EXPECT_TRUE(refused({0}, std::numeric_limits<double>::quiet_NaN()));
}

}  // namespace
}  // namespace afferent
