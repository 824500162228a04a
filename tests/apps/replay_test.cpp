#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/apps/process.hpp"

namespace afferent {
namespace {

using Json = nlohmann::json;

std::string grasp_to_record(double duration_s, const std::string& link, double close_for_s = 0.6) {
    return "duration_s: " + std::to_string(duration_s) +
           " hand { user { close_at_s: 0.1 close_for_s: " + std::to_string(close_for_s) +
           " hold_for_s: 0.4 open_for_s: 0.2 effort: 0.7 }"
           " object { distance_mm: 5 stiffness_n_per_mm: 1 } } link { " +
           link + " }";
}
const std::string link_to_record = "unix_socket { path: 'hand.sock' }";
const std::string patient_link = link_to_record + " " + less_patient;

class Replay : public testing::Test {
  protected:
    // Replays as fast as it goes, into "replay"; the summary.
    Json replay(const std::string& file, std::vector<std::string> more = {"--fast"}) {
        std::vector<std::string> arguments{"replay", folder_(file), "--out", folder_("replay"), "--json"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        Process process(arguments);
        EXPECT_EQ(process.wait(), 0) << process.err();
        return Json::parse(process.out());
    }

    void expect_equal(const std::string& recorded, const std::string& replayed = "replay") {
        for (const char* table : {"/force.csv", "/emg.csv"}) {
            const std::string content = read_file(folder_ / (recorded + table));
            EXPECT_GT(content.size(), 10'000U);
            EXPECT_TRUE(content == read_file(folder_ / (replayed + table))) << recorded << table;
        }
    }

    // The replay began at this time.
    void expect_part_equal(const std::string& from_s) {
        const std::string whole = read_file(folder_ / "run/force.csv");
        const std::string part = read_file(folder_ / "replay/force.csv");
        const std::size_t from = whole.find("\n" + from_s + "00000000,");
        ASSERT_NE(from, std::string::npos);
        EXPECT_EQ(whole.substr(0, whole.find('\n')) + whole.substr(from), part);
    }

    Json run(const std::string& scene, std::vector<std::string> more = {}) {
        std::vector<std::string> arguments{
            "run", scene, "--out", folder_("run"), "--record", folder_("r.afferent"), "--json"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        Process process(arguments);
        EXPECT_EQ(process.wait(), 0) << process.err();
        return Json::parse(process.out());
    }

    Folder folder_;
};

TEST_F(Replay, OfARunWritesTheSameTables) {
    for (const char* scene : {"grasp", "recorded", "two_channels"}) {
        const Json recorded = run(examples + scene + ".txtpb");
        const Json replayed = replay("r.afferent");
        expect_equal("run");
        EXPECT_EQ(replayed.at("events"), recorded.at("events"));
        EXPECT_TRUE(recorded.at("force_error_rms_n").is_number());
        EXPECT_EQ(replayed.at("force_error_rms_n"), recorded.at("force_error_rms_n"));
        EXPECT_TRUE(std::filesystem::exists(folder_ / "replay/summary.json"));
    }
}

// For each patch and each element, whose true force follows from its share or from a column of its own.
TEST_F(Replay, WritesTheSamePartsAsTheRun) {
    write_file(folder_ / "t.csv", "time_s,a_n,b_n,c_n\n0,0,0,0\n0.5,1,3,2\n0.6,3,1,2\n1.5,3,1.5,2\n");
    const std::string table =
        "duration_s: 2 source { table { path: 't.csv' } } patch { name: 'thumb' elements: 2 } "
        "patch { name: 'index' elements: 1 } ";
    for (const std::string& text :
         {table + "link { tcp {} } decoder { filter {} parts: PATCHES }",
          grasp_to_record(2, "tcp {}") + "decoder { inversion {} parts: ELEMENTS }"}) {
        const Json recorded = run(write_file(folder_ / "s.txtpb", text).string());
        EXPECT_FALSE(recorded.at("part_force_error_rms_n").empty());
        EXPECT_EQ(replay("r.afferent")["part_force_error_rms_n"], recorded.at("part_force_error_rms_n"));
        expect_equal("run");
    }
    run(write_file(folder_ / "s.txtpb", table + "link { tcp {} } decoder { parts: PATCHES }").string());
    const std::string force = read_file(folder_ / "run/force.csv");
    EXPECT_EQ(force.substr(0, force.find('\n')),
              "time_s,true_force_n,estimate_n,sigma_n,rate_hz,gain,doubt,thumb_true_n,thumb_estimate_n,thumb_"
              "sigma_n,"
              "thumb_doubt,index_true_n,index_estimate_n,index_sigma_n,index_doubt");
    replay("r.afferent", {"--fast", "--from-s", "1.8"});
    expect_part_equal("1.8");
}

// In open loop another decoder gives the same on the recorded packets as in a run.
TEST_F(Replay, WithAnotherDecoderIsARunWithThatDecoder) {
    const std::string open_loop =
        "duration_s: 2 link { tcp {} } gain { limit_n: 8 accept_unreachable_limit: true } source { profile { "
        "point {} point { time_s: 0.5 } "
        "point { time_s: 0.8 force_n: 6 } point { time_s: 1.5 force_n: 6 } point { time_s: 1.7 } } } decoder "
        "{ curve: ONSET ";
    const auto scene = [&](const std::string& decoder) {
        return write_file(folder_ / "s.txtpb", open_loop + decoder + " }").string();
    };
    const std::string decoders[] = {"sliding_window {}", "exponential { time_constant_ms: 25 }",
                                    "interval {}", "inversion {}", "filter {}"};
    for (const std::string& decoder : decoders) {
        run(scene(decoders[0]));
        std::filesystem::rename(folder_ / "r.afferent", folder_ / "window.afferent");
        run(scene(decoder));
        replay("window.afferent", {"--fast", "--decoder", decoder});
        expect_equal("run");
    }
    // By its name alone.
    replay("window.afferent", {"--fast", "--decoder", "filter"});
    expect_equal("run");
}

// The hand moves as it did, by the estimates of the decoder that it had.
TEST_F(Replay, WithAnotherDecoderKeepsTheTrueForceOfTheGrasp) {
    run(write_file(folder_ / "s.txtpb", grasp_to_record(2, "tcp {}")).string());
    const auto true_forces = [&](const std::string& file) {
        std::vector<std::string> all;
        std::istringstream lines(read_file(folder_ / file));
        for (std::string line; std::getline(lines, line);) {
            const std::size_t begin = line.find(',') + 1;
            all.push_back(line.substr(begin, line.find(',', begin) - begin));
        }
        return all;
    };
    const double window = replay("r.afferent")["force_error_rms_n"];
    const double filter = replay("r.afferent", {"--fast", "--decoder", "filter"})["force_error_rms_n"];
    EXPECT_EQ(true_forces("replay/force.csv"), true_forces("run/force.csv"));
    EXPECT_LT(filter, window / 2);
    const double same = replay("r.afferent", {"--fast", "--decoder", "sliding_window"})["force_error_rms_n"];
    EXPECT_EQ(same, window);
    expect_equal("run");
}

TEST_F(Replay, SaysWhichDecodersThereAre) {
    run(write_file(folder_ / "s.txtpb", grasp_to_record(0.5, "tcp {}")).string());
    for (const auto& [decoder, why] :
         {std::pair{"filtre", "there is no decoder filtre; did you mean filter?"},
          {"window_ms: 40", "there is no decoder window_ms"},
          {"nonsense",
           "--decoder: there is no decoder nonsense\n"
           "decoders: sliding_window, exponential, interval, inversion, filter"},
          {"nonsense { window_ms: 40 }", "there is no decoder nonsense\n"},
          {"filter {} pooling: PER_NEURON", "all else is as recorded"},
          {"exponential { time_constant_ms: 0 }", "time_constant_ms"}}) {
        Process process({"replay", folder_("r.afferent"), "--fast", "--decoder", decoder});
        EXPECT_GT(process.wait(), 0);
        EXPECT_NE(process.err().find(why), std::string::npos) << process.err();
    }
}

// One of nine elements is dead, and the force is held until the end.
TEST_F(Replay, TellsHowManyAfferentsTheDecoderLeavesOut) {
    const std::string dead_element =
        "duration_s: 3 link { tcp {} } patch { name: 'finger' elements: 9 sensor { dead_element: 4 } } "
        "source { profile { point {} point { time_s: 0.5 } point { time_s: 0.8 force_n: 8 } } } ";
    const auto scene = [&](const std::string& decoder) {
        return write_file(folder_ / "s.txtpb", dead_element + "decoder { " + decoder + " }").string();
    };
    const Json recorded = run(scene("filter {}"));
    EXPECT_EQ(recorded.at("left_out_afferents"), 1);
    EXPECT_EQ(replay("r.afferent")["left_out_afferents"], 1);
    Process text({"replay", folder_("r.afferent"), "--fast"});
    EXPECT_EQ(text.wait(), 0) << text.err();
    EXPECT_NE(text.out().find("left out afferents"), std::string::npos) << text.out();

    EXPECT_FALSE(run(scene("sliding_window {}")).contains("left_out_afferents"));
    EXPECT_FALSE(replay("r.afferent").contains("left_out_afferents")) << "only the filter judges";
    EXPECT_EQ(replay("r.afferent", {"--fast", "--decoder", "filter"})["left_out_afferents"], 1);
}

TEST_F(Replay, OfAnImperfectChannelWritesTheSameTables) {
    const auto scene =
        write_file(folder_ / "s.txtpb",
                   grasp_to_record(2,
                                   "tcp {} channel { loss: 0.2 corrupt: 0.1 duplicate: 0.1 latency_ms: 4 "
                                   "jitter_ms: 30 reorder: 0.1 }"));
    const Json recorded = run(scene.string());
    const Json replayed = replay("r.afferent");
    expect_equal("run");
    for (const char* count : {"gaps", "lost_events", "late_packets", "out_of_order_packets"})
        EXPECT_EQ(replayed.at(count), recorded.at(count)) << count;
}

TEST_F(Replay, TakesTheCommandLinesSeedAndTables) {
    run(examples + "recorded.txtpb", {"--seed", "5", "--emg", examples + "data/emg.csv"});
    EXPECT_EQ(replay("r.afferent")["seed"], 5);
    expect_equal("run");
}

TEST_F(Replay, BeginsWhereItIsTold) {
    run(examples + "grasp.txtpb");
    replay("r.afferent", {"--fast", "--from-s", "6.5"});
    expect_part_equal("6.5");
}

TEST_F(Replay, KeepsThePaceItIsTold) {
    const auto scene = write_file(folder_ / "s.txtpb", grasp_to_record(1, "tcp {}"));
    run(scene.string());
    const double twice = replay("r.afferent", {"--speed", "2"})["run_time_s"];
    EXPECT_GE(twice, 0.499);
    expect_equal("run");
}

// In real time, with a coprocessor that is killed and comes back.
TEST_F(Replay, OfTwoProcessesWritesTheSameTables) {
    const auto scene =
        write_file(folder_ / "s.txtpb", seed_of_its_own() + grasp_to_record(9, patient_link, 8)).string();
    Process hand({"hand", scene, "--out", folder_("hand"), "--record", folder_("h.afferent"), "--json"});
    {
        Process coprocessor({"coprocessor", scene});
        ASSERT_TRUE(hand.has_said("the coprocessor is there"));
        ASSERT_TRUE(comes_to_operate(scene)) << hand.err();
        coprocessor.signal(SIGKILL);
        coprocessor.wait();
    }
    EXPECT_TRUE(hand.has_said("safe state")) << hand.err();
    Process again({"coprocessor", scene, "--record", folder_("c.afferent")});
    EXPECT_EQ(again.wait(), 0) << again.err();
    EXPECT_EQ(hand.wait(), 1) << hand.err();
    const Json recorded = Json::parse(hand.out());
    const Json replayed = replay("h.afferent");
    expect_equal("hand");
    for (const char* count :
         {"sessions", "events", "packets", "late_packets", "gaps", "lost_events", "freezes", "safe_states"})
        EXPECT_EQ(replayed.at(count), recorded.at(count)) << count;
    EXPECT_EQ(replayed.at("sessions"), 2);
    EXPECT_EQ(replayed.at("safe_states"), 1);
    // What was sent after the restart.
    EXPECT_GT(replay("c.afferent")["events"], 0);
}

// The samples are with the coprocessor, which begins again at the start of the scene. The hand's own clock
// goes on meanwhile: the second coprocessor has the rest of the scene to come.
TEST_F(Replay, OfAHandThatStartsOverWritesTheSameTables) {
    std::filesystem::copy(examples + "data", folder_ / "data");
    const auto scene = write_file(folder_ / "s.txtpb",
                                  "duration_s: 7 source { table { path: 'data/grip.csv' } } "
                                  "hand { emg_table { path: 'data/emg.csv' } } link { " +
                                      patient_link + " }")
                           .string();
    Process hand({"hand", scene, "--out", folder_("hand"), "--record", folder_("h.afferent")});
    {
        Process coprocessor({"coprocessor", scene});
        ASSERT_TRUE(hand.has_said("the coprocessor is there"));
        std::this_thread::sleep_for(std::chrono::milliseconds(500));
        coprocessor.signal(SIGKILL);
        coprocessor.wait();
    }
    EXPECT_TRUE(hand.has_said("broken off")) << hand.err();
    Process again({"coprocessor", scene});
    EXPECT_EQ(again.wait(), 0) << again.err();
    EXPECT_EQ(hand.wait(), 1) << hand.err();
    replay("h.afferent");
    expect_equal("hand");
    expect_equal("hand/session-2", "replay/session-2");
}

TEST_F(Replay, OfAKilledHandHasWhatItHad) {
    const auto scene = write_file(folder_ / "s.txtpb", grasp_to_record(30, patient_link, 25)).string();
    {
        Process hand({"hand", scene, "--record", folder_("h.afferent")});
        Process coprocessor({"coprocessor", scene});
        ASSERT_TRUE(hand.has_said("the coprocessor is there"));
        ASSERT_TRUE(comes_true([&] {
            Process status({"link", "status", scene, "--json"});
            status.wait();
            Json told = Json::parse(status.out(), nullptr, false);
            return told.is_object() && told["hand"]["at_s"].is_number() && told["hand"]["at_s"] > 1.2 &&
                   told["hand"]["events"] > 200;
        })) << hand.err();
        hand.signal(SIGKILL);
        hand.wait();
    }
    const Json replayed = replay("h.afferent");
    EXPECT_EQ(replayed.at("closed"), false);
    EXPECT_GT(replayed.at("until_s"), 0.9);
    EXPECT_GT(replayed.at("events"), 50);
}

TEST_F(Replay, EndsCleanlyOnCtrlC) {
    run(examples + "grasp.txtpb");
    Process process(
        {"replay", folder_("r.afferent"), "--speed", "0.01", "--out", folder_("replay"), "--json"});
    ASSERT_TRUE(comes_true([&] { return has_begun_in(folder_ / "replay"); })) << process.err();
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    process.signal(SIGINT);
    EXPECT_EQ(process.wait(), 130);
    EXPECT_LT(Json::parse(process.out()).at("until_s").get<double>(), 1);
    EXPECT_TRUE(std::filesystem::exists(folder_ / "replay/force.csv"));
}

TEST_F(Replay, IsWhatAHandDoesWhoseLinkIsAFile) {
    std::filesystem::copy(examples + "data", folder_ / "data");
    const std::string source =
        "duration_s: 3 source { table { path: 'data/grip.csv' } } hand { emg_table { path: 'data/emg.csv' } "
        "} ";
    const auto file =
        write_file(folder_ / "file.txtpb", source + "link { file { path: 'link.afferent' } }").string();
    const auto tcp = write_file(folder_ / "tcp.txtpb", source + "link { tcp {} }").string();
    run(tcp);
    Process coprocessor({"coprocessor", file, "--lockstep", "--out", folder_("c"), "--json"});
    EXPECT_EQ(coprocessor.wait(), 0) << coprocessor.err();
    for (const char* const table : {"events.csv", "emg.csv", "force.csv"})
        EXPECT_GT(read_file(folder_ / "run" / table).size(), 1000U) << table;
    EXPECT_EQ(read_file(folder_ / "c/events.csv"), read_file(folder_ / "run/events.csv"));
    Process hand({"hand", file, "--lockstep", "--out", folder_("hand"), "--json"});
    EXPECT_EQ(hand.wait(), 0) << hand.err();
    EXPECT_EQ(read_file(folder_ / "hand/emg.csv"), read_file(folder_ / "run/emg.csv"));
    EXPECT_EQ(Json::parse(hand.out()).at("events"), Json::parse(coprocessor.out()).at("events"));

    Process whole({"run", file, "--out", folder_("whole")});
    EXPECT_EQ(whole.wait(), 0) << whole.err();
    Process again({"hand", file, "--lockstep", "--out", folder_("again")});
    EXPECT_EQ(again.wait(), 0) << again.err();
    EXPECT_EQ(read_file(folder_ / "again/force.csv"), read_file(folder_ / "run/force.csv"));

    Process other({"hand", file, "--seed", "99"});
    EXPECT_EQ(other.wait(), 1);
    EXPECT_NE(other.err().find("of another scene"), std::string::npos) << other.err();
}

TEST_F(Replay, CannotAskAFileForSamples) {
    const auto scene = write_file(folder_ / "s.txtpb", grasp_to_record(1, "file { path: 'l.afferent' }"));
    Process process({"coprocessor", scene.string()});
    EXPECT_EQ(process.wait(), 1);
    EXPECT_NE(process.err().find("the samples are the hand's"), std::string::npos) << process.err();
    const auto nameless = write_file(folder_ / "n.txtpb", "link { file {} }");
    Process refused({"run", nameless.string()});
    EXPECT_EQ(refused.wait(), 1);
    EXPECT_NE(refused.err().find("file.path must be"), std::string::npos) << refused.err();
}

TEST_F(Replay, SaysWhatIsWrongWithAFile) {
    const auto said = [&](const std::string& file) {
        Process process({"replay", file, "--fast"});
        EXPECT_EQ(process.wait(), 1);
        return process.err();
    };
    EXPECT_NE(said(folder_("none")).find("No such file"), std::string::npos);
    EXPECT_NE(said(folder_("")).find("cannot be read: it is a folder"), std::string::npos);
    EXPECT_NE(said(examples + "grasp.txtpb").find("is not a recording"), std::string::npos);
    run(examples + "grasp.txtpb");
    std::filesystem::resize_file(folder_ / "r.afferent", 100);
    EXPECT_NE(said(folder_("r.afferent")).find("has no head"), std::string::npos);
}

}  // namespace
}  // namespace afferent
