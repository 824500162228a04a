// Runs in several processes, as a user starts them.
#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/apps/process.hpp"

namespace afferent {
namespace {

using RankJson = nlohmann::json;

// mpirun in this test's environment: as root, as in a container, and with more ranks than processors.
class RankedRuns : public ::testing::Test {
  protected:
    RankedRuns() {
        for (const char* name : {"OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM",
                                 "OMPI_MCA_rmaps_base_oversubscribe"})
            ::setenv(name, "1", 1);
        // Ranks of other tests are on the same processors.
        ::setenv("OMPI_MCA_hwloc_base_binding_policy", "none", 1);
    }

    // The run of a scene: by itself where ranks is 1.
    std::unique_ptr<Process> start(int ranks, std::vector<std::string> arguments,
                                   const std::string& input = "") {
        arguments.insert(arguments.begin(), "run");
        if (ranks == 1) return std::make_unique<Process>(arguments, input);
        arguments.insert(arguments.begin(), {"-n", std::to_string(ranks), AFFERENT_PROGRAM});
        return std::make_unique<Process>(arguments, input, MPIRUN_PROGRAM);
    }

    // What is written of a run: its summary without times, its tables, and its recording but for the hello's
    // nonce, which is another each time.
    struct Written {
        RankJson summary;
        std::string events;
        std::string force;
        std::string recording;
    };

    Written run(int ranks, const std::string& scene, const std::string& input = "") {
        const std::string name = std::to_string(ranks);
        const auto process = start(
            ranks, {scene, "--json", "--out", folder_(name), "--record", folder_(name + ".afferent")}, input);
        EXPECT_EQ(process->wait(), 0) << ranks << " ranks: " << process->err();
        Written written{.summary = RankJson::parse(process->out(), nullptr, false),
                        .events = read_file(folder_ / name / "events.csv"),
                        .force = read_file(folder_ / name / "force.csv"),
                        .recording = read_file(folder_ / (name + ".afferent"))};
        EXPECT_FALSE(written.summary.is_discarded()) << process->out();
        return written;
    }

    static std::size_t different_bytes(const std::string& a, const std::string& b) {
        EXPECT_EQ(a.size(), b.size());
        std::size_t count = 0;
        for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) count += a[i] != b[i];
        return count;
    }

    void expect_equal_for_any_number_of_ranks(const std::string& scene, const std::string& input = "") {
        const Written alone = run(1, scene, input);
        ASSERT_GT(std::count(alone.events.begin(), alone.events.end(), '\n'), 100) << scene;
        for (const int ranks : {2, 3}) {
            const Written together = run(ranks, scene, input);
            EXPECT_TRUE(together.events == alone.events) << scene << ", " << ranks << " ranks";
            EXPECT_TRUE(together.force == alone.force) << scene << ", " << ranks << " ranks";
            // The nonce has eight bytes, the checksum of its frame four.
            EXPECT_LE(different_bytes(together.recording, alone.recording), 12U) << scene;
            EXPECT_EQ(together.summary.at("ranks"), ranks);
            EXPECT_EQ(together.summary.at("rank_afferents").size(), static_cast<std::size_t>(ranks));
            std::uint64_t events = 0;
            for (const auto& count : together.summary.at("rank_events")) events += count.get<std::uint64_t>();
            EXPECT_EQ(events, together.summary.at("events"));
            for (const auto& [key, value] : alone.summary.items()) {
                if (key == "run_time_s") continue;
                // Not known where rank 0 does not sample everything.
                if (key == "raw_sample_bytes" && together.summary.at(key).is_null()) continue;
                EXPECT_EQ(together.summary.at(key), value) << scene << ": " << key;
            }
        }
    }

    // The process of that rank in a run whose arguments include this one; 0: it is not there.
    static pid_t rank_of(const std::string& argument, int rank) {
        for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
            const std::string id = entry.path().filename();
            if (id.find_first_not_of("0123456789") != std::string::npos) continue;
            if (!read_file(entry.path() / "cmdline").starts_with("afferent-ranks")) continue;
            if (read_file(entry.path() / "cmdline").find(argument) == std::string::npos) continue;
            const std::string wanted = "OMPI_COMM_WORLD_RANK=" + std::to_string(rank) + '\0';
            if (read_file(entry.path() / "environ").find(wanted) != std::string::npos) return std::stoi(id);
        }
        return 0;
    }

    // A run that takes longer than the test, in the midst of its scene.
    std::unique_ptr<Process> start_long_run(int ranks, std::vector<std::string> options = {}) {
        write_file(folder_ / "long.txtpb", R"(
            duration_s: 1000 every_patch { elements: 3 encoder { sustained { gain_mv_per_n: 1 bias_mv: 40 } } }
            source { profile { point { force_n: 1 } } } link { unix_socket {} })");
        options.insert(options.begin(),
                       {folder_("long.txtpb"), "--realtime", "--record", folder_("long.afferent")});
        auto process = start(ranks, options);
        EXPECT_TRUE(comes_true([&] {
            std::error_code none;
            return std::filesystem::file_size(folder_ / "long.afferent", none) > 3000 && !none;
        })) << process->err();
        return process;
    }

    void expect_readable_recording() {
        Process replay({"replay", folder_("long.afferent"), "--fast", "--json"});
        EXPECT_EQ(replay.wait(), 0) << replay.err();
        const auto summary = RankJson::parse(replay.out(), nullptr, false);
        ASSERT_FALSE(summary.is_discarded()) << replay.out();
        EXPECT_GT(summary.at("events"), 10);
        EXPECT_EQ(summary.at("refused_packets"), 0);
    }

    const Folder folder_;
};

TEST_F(RankedRuns, HaveTheEventsOfOneOnAGrasp) {
    expect_equal_for_any_number_of_ranks(examples + "grasp.txtpb");
}

TEST_F(RankedRuns, HaveTheEventsOfOneOnAFingertip) {
    expect_equal_for_any_number_of_ranks(examples + "fingertip.txtpb");
}

// Afferents that differ, over several patches of which one reads another's elements.
std::string rank_population(const std::string& form) {
    return R"(
    duration_s: 0.6 seed: 5 record { force: false picture: false }
    every_patch {
        sensor { noise_counts: 2 }
        encoder { sustained { gain_mv_per_n: 400 bias_mv: 5 } }
        spread { gain { log_normal { sigma: 0.2 } } phase { uniform { lowest: 0 } } }
    }
    patch { name: "a" elements: 300 }
    patch { name: "b" elements: 300 neuron { form: )" +
           form + R"( } }
    patch { name: "c" elements_of: "a" encoder { transient { gain_mv_s_per_n: 20 } } neuron { form: SPARSE } }
    link { unix_socket { path: "p.sock" } }
)";
}

TEST_F(RankedRuns, HaveTheEventsOfOneOnAPopulation) {
    write_file(folder_ / "s.txtpb", rank_population("DENSE") + R"(
        source { profile { point { force_n: 0 } point { time_s: 0.1 force_n: 30 }
                           point { time_s: 0.4 force_n: 40 } point { time_s: 0.5 force_n: 0 } } })");
    expect_equal_for_any_number_of_ranks(folder_("s.txtpb"));
}

std::string rising_table(int rows) {
    std::string table = "time_s,grip_n\n";
    for (int i = 0; i < rows; ++i) table += std::to_string(0.005 * i) + "," + std::to_string(i % 60) + "\n";
    return table;
}

TEST_F(RankedRuns, ReadATableEach) {
    write_file(folder_ / "t.csv", rising_table(120));
    write_file(folder_ / "s.txtpb", rank_population("SPARSE") + "source { table { path: 't.csv' } }");
    expect_equal_for_any_number_of_ranks(folder_("s.txtpb"));
}

TEST_F(RankedRuns, AreSentWhatOnlyTheFirstReads) {
    write_file(folder_ / "s.txtpb", rank_population("SPARSE") + "source { standard_input {} }");
    expect_equal_for_any_number_of_ranks(folder_("s.txtpb"), rising_table(120));
}

TEST_F(RankedRuns, LeaveRanksWithoutNeuronsIdle) {
    const Written alone = run(1, examples + "paper.txtpb");
    const Written together = run(2, examples + "paper.txtpb");
    EXPECT_GT(std::count(alone.events.begin(), alone.events.end(), '\n'), 100);
    EXPECT_EQ(together.events, alone.events);
    EXPECT_EQ(together.summary.at("rank_afferents"), (std::vector<int>{0, 1}));
}

TEST_F(RankedRuns, SayOnceWhatIsWrongWithTheScene) {
    write_file(folder_ / "s.txtpb", "patch { elements: 0 }");
    const auto process = start(3, {folder_("s.txtpb")});
    EXPECT_EQ(process->wait(), 1);
    const std::string said = process->err();
    const auto first = said.find("elements");
    ASSERT_NE(first, std::string::npos) << said;
    EXPECT_EQ(said.find("elements", first + 20), std::string::npos) << said;
}

// The others are told, and end: the third would have months to compute, and is not given up.
TEST_F(RankedRuns, NameTheRankThatFails) {
    write_file(folder_ / "s.txtpb", R"(
        duration_s: 1e7 every_patch { elements: 2 encoder { sustained { gain_mv_per_n: 100000 } } }
        patch { name: "calm" share: 0 share: 0 } patch { name: "wild" } patch { name: "still" share: 0 share: 0 }
        source { profile { point { force_n: 0 } point { time_s: 0.1 force_n: 0 } point { time_s: 0.2 force_n: 5 } } }
        runtime { spikes_per_window: 3 })");
    Process alone({"run", folder_("s.txtpb")});
    EXPECT_EQ(alone.wait(), 1);
    const std::string storm = alone.err();
    ASSERT_NE(storm.find("fires more often than"), std::string::npos) << storm;
    const auto together = start(3, {folder_("s.txtpb"), "--rank-timeout", "20"});
    EXPECT_EQ(together->wait(), 1);
    EXPECT_NE(together->err().find("rank 1 of 3: " + storm), std::string::npos) << together->err();
    EXPECT_EQ(together->err().find("MPI_ABORT"), std::string::npos) << together->err();
}

// mpirun takes the time between asking a process to end and killing it; it does that within seconds.
constexpr auto soon = std::chrono::seconds(60);

TEST_F(RankedRuns, EndWithAnErrorWhereARankDies) {
    for (const int rank : {1, 0}) {
        const auto process = start_long_run(3);
        const pid_t victim = rank_of(folder_("long.afferent"), rank);
        ASSERT_NE(victim, 0);
        const auto begin = std::chrono::steady_clock::now();
        ::kill(victim, SIGKILL);
        EXPECT_GT(process->wait(), 0);
        EXPECT_LT(std::chrono::steady_clock::now() - begin, soon);
        EXPECT_NE(process->err().find("rank " + std::to_string(rank)), std::string::npos) << process->err();
        expect_readable_recording();
        std::filesystem::remove(folder_ / "long.afferent");
    }
}

TEST_F(RankedRuns, EndWithAnErrorWhereARankHangs) {
    const auto process = start_long_run(2, {"--rank-timeout", "2"});
    const pid_t victim = rank_of(folder_("long.afferent"), 1);
    ASSERT_NE(victim, 0);
    const auto begin = std::chrono::steady_clock::now();
    ::kill(victim, SIGSTOP);
    EXPECT_EQ(process->wait(), 1);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, soon);
    EXPECT_NE(process->err().find("rank 1 of 2: has not sent its events up to "), std::string::npos)
        << process->err();
    EXPECT_NE(process->err().find("within 2000 ms (--rank-timeout)"), std::string::npos) << process->err();
    expect_readable_recording();
}

TEST_F(RankedRuns, EndWhenTheyAreToldTo) {
    const auto process = start_long_run(2);
    process->signal(SIGINT);
    EXPECT_NE(process->wait(), 0);
    expect_readable_recording();
}

TEST_F(RankedRuns, RefuseAWrongCommandLineOnce) {
    const auto process = start(2, {"s.txtpb", "--sed", "1"});
    EXPECT_GE(process->wait(), 100);
    const std::string said = process->err();
    EXPECT_NE(said.find("did you mean --seed?"), std::string::npos) << said;
    EXPECT_EQ(said.find("did you mean"), said.rfind("did you mean")) << said;
}

}  // namespace
}  // namespace afferent
