#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "tests/apps/process.hpp"

namespace afferent {
namespace {

using Json = nlohmann::json;

TEST(Program, ExplainsEveryCommandWithAnExample) {
    for (const char* command : {"run", "plan", "tune", "coprocessor", "hand", "replay"}) {
        Process process({command, "--help"});
        EXPECT_EQ(process.wait(), 0);
        EXPECT_NE(process.out().find("Example"), std::string::npos) << command;
        EXPECT_NE(process.out().find(std::string("afferent ") + command), std::string::npos) << command;
    }
}

TEST(Program, RefusesWhatItDoesNotKnow) {
    for (const auto& arguments :
         {std::vector<std::string>{}, {"fly"}, {"run"}, {"run", "x", "--seed", "-1"}}) {
        Process process(arguments);
        EXPECT_GT(process.wait(), 0);
    }
}

TEST(Program, TellsAWrongCommandLineFromAFailure) {
    Process help({"--help"});
    EXPECT_EQ(help.wait(), 0);
    EXPECT_NE(help.out().find("Exit codes:"), std::string::npos);
    Process wrong({"run", examples + "grasp.txtpb", "--seed", "-1"});
    EXPECT_GE(wrong.wait(), 100);
    EXPECT_NE(wrong.err().find("--seed: must be >= 0, is -1\n"), std::string::npos) << wrong.err();
    Process failed({"run", examples + "no_such.txtpb"});
    EXPECT_EQ(failed.wait(), 1);
}

struct Misspelt {
    std::vector<std::string> arguments;
    const char* said;
};

// The commands of the README, without those that take a second terminal or minutes, and the benchmarks.
std::vector<std::string> readme_commands() {
    static const std::regex alone(
        "    afferent (run|plan|tuning|tune(?! --gain)|replay|calibrate|convert|movie|keys|neuron) [^#]*");
    std::istringstream readme(read_file(AFFERENT_SOURCE_DIR "/README.md"));
    std::vector<std::string> shown;
    for (std::string line; std::getline(readme, line);)
        if (std::smatch match; std::regex_search(line, match, alone, std::regex_constants::match_continuous))
            shown.push_back(match.str());
    return shown;
}

TEST(Program, RunsTheCommandsOfTheReadmeAsTheyStandThere) {
    const Folder folder;
    std::filesystem::create_directory_symlink(examples, folder / "examples");
    std::filesystem::create_symlink(AFFERENT_PROGRAM, folder / "afferent");
    const std::vector<std::string> shown = readme_commands();
    EXPECT_GE(shown.size(), 10U);
    for (const std::string& command : shown) {
        Process process({"-c", "cd '" + folder("") + "' && PATH=.:$PATH && " + command}, "", "/bin/sh");
        EXPECT_EQ(process.wait(), 0) << command << '\n' << process.err();
    }
    for (const char* written :
         {"out/grasp/force.csv", "out/replay/force.csv", "g.afferent", "grasp.nwb", "fingertip.html", "keys"})
        EXPECT_TRUE(std::filesystem::exists(folder / written)) << written;
}

TEST(Program, SuggestsTheNearestCommandOrOption) {
    for (const Misspelt& misspelt :
         {Misspelt{{"rnu", "x"}, "afferent: there is no command rnu; did you mean run?"},
          Misspelt{{"link", "stauts"}, "afferent link: there is no command stauts; did you mean status?"},
          Misspelt{{"run", "--jsn"}, "afferent run: there is no option --jsn; did you mean --json?"},
          Misspelt{{"run", "x", "--ot", "y"}, "there is no option --ot; did you mean --out?"},
          Misspelt{{"run", "x", "--ot=y"}, "there is no option --ot; did you mean --out?"},
          Misspelt{{"link", "status", "x", "--wacth"}, "afferent link status: there is no option --wacth"}}) {
        Process process(misspelt.arguments);
        EXPECT_GE(process.wait(), 100);
        EXPECT_NE(process.err().find(misspelt.said), std::string::npos) << process.err();
    }
    Process far({"fly"});
    EXPECT_GE(far.wait(), 100);
    EXPECT_NE(far.err().find("there is no command fly\n"), std::string::npos) << far.err();
}

// The program by itself, in a folder of its own.
std::string copy_to(const Folder& folder) {
    std::filesystem::copy_file(AFFERENT_PROGRAM, folder / "afferent");
    return folder("afferent");
}

TEST(Program, StartsTheBenchmarksBesideItWithTheArgumentsAsTheyStand) {
    const Folder folder;
    const std::string program = copy_to(folder);
    write_file(folder / "afferent-bench", "#!/bin/sh\nprintf '%s|' \"$@\"\nexit 7\n");
    std::filesystem::permissions(folder / "afferent-bench", std::filesystem::perms::owner_all);
    Process process({"bench", "error", "--help", "a b", "--"}, "", program);
    EXPECT_EQ(process.wait(), 7);
    EXPECT_EQ(process.out(), "error|--help|a b|--|");
}

TEST(Program, SaysHowToBuildTheBenchmarks) {
    const Folder folder;
    Process process({"bench", "error"}, "", copy_to(folder));
    EXPECT_EQ(process.wait(), 1);
    EXPECT_NE(process.err().find("scripts/build.sh release afferent-bench"), std::string::npos)
        << process.err();
}

// As mpirun starts it.
struct AsRank {
    explicit AsRank(const char* rank) {
        ::setenv("OMPI_COMM_WORLD_SIZE", "2", 1);
        ::setenv("OMPI_COMM_WORLD_RANK", rank, 1);
    }
    ~AsRank() {
        ::unsetenv("OMPI_COMM_WORLD_SIZE");
        ::unsetenv("OMPI_COMM_WORLD_RANK");
    }
};

TEST(Program, BecomesARankOfARunInSeveralProcesses) {
    const Folder folder;
    const std::string program = copy_to(folder);
    write_file(folder / "afferent-ranks", "#!/bin/sh\nprintf '%s|' \"$@\"\nexit 7\n");
    std::filesystem::permissions(folder / "afferent-ranks", std::filesystem::perms::owner_all);
    const AsRank rank("1");
    Process process({"run", "a scene", "--seed", "3"}, "", program);
    EXPECT_EQ(process.wait(), 7);
    EXPECT_EQ(process.out(), "run|a scene|--seed|3|");
    Process other({"plan", examples + "grasp.txtpb"}, "", program);
    EXPECT_EQ(other.wait(), 0) << other.err();
}

TEST(Program, SaysOnceHowToBuildRunsInSeveralProcesses) {
    const Folder folder;
    const std::string program = copy_to(folder);
    for (const char* number : {"0", "1"}) {
        const AsRank rank(number);
        Process process({"run", examples + "grasp.txtpb"}, "", program);
        const bool first = *number == '0';
        EXPECT_EQ(process.wait(), first ? 1 : 0);
        EXPECT_EQ(process.err().find("scripts/build.sh release -DAFFERENT_MPI=ON afferent-ranks") !=
                      std::string::npos,
                  first)
            << process.err();
    }
}

TEST(Program, NamesTheSolversThatANeuronHasElsewhere) {
    const Folder folder;
    const auto drive = write_file(folder / "drive.csv", "time_s,drive_mv\n0,30\n0.1,0\n").string();
    Process exact({"neuron", "--drive", drive});
    EXPECT_EQ(exact.wait(), 0) << exact.err();
    const std::string table = exact.out();
    EXPECT_GT(std::count(table.begin(), table.end(), '\n'), 1);
    Process other({"neuron", "--drive", drive, "--solver", "euler:0.1"});
    EXPECT_EQ(other.wait(), 1);
    EXPECT_NE(other.err().find("afferent bench neuron"), std::string::npos) << other.err();
}

TEST(Program, WritesWhatARunComputes) {
    const Folder folder;
    Process process({"run", examples + "grasp.txtpb", "--out", folder("out"), "--json"});
    ASSERT_EQ(process.wait(), 0) << process.err();
    const Json summary = Json::parse(process.out());
    EXPECT_EQ(summary, Json::parse(read_file(folder / "out/summary.json")));
    EXPECT_LT(summary.at("link_bytes").get<double>(), summary.at("raw_sample_bytes").get<double>());
    EXPECT_TRUE(summary.at("force_error_rms_n").is_number());

    const std::string events = read_file(folder / "out/events.csv");
    EXPECT_EQ(events.substr(0, events.find('\n')), "time_s,address");
    EXPECT_EQ(std::count(events.begin(), events.end(), '\n') - 1, summary.at("events"));
    const std::string force = read_file(folder / "out/force.csv");
    EXPECT_EQ(force.substr(0, force.find('\n')), "time_s,true_force_n,estimate_n,sigma_n,rate_hz,gain,doubt");
    EXPECT_EQ(std::count(force.begin(), force.end(), '\n') - 1, 10'000);
    if (process.err().find("gnuplot is not installed") == std::string::npos) {
        EXPECT_GT(std::filesystem::file_size(folder / "out/grasp.png"), 10'000U);
        EXPECT_GT(std::filesystem::file_size(folder / "out/grasp.svg"), 10'000U);
    }
}

TEST(Program, GivesTheSameForTheSameSeed) {
    const Folder folder;
    for (const char* name : {"a", "b"}) {
        Process process({"run", examples + "grasp.txtpb", "--seed", "7", "--out", folder(name)});
        ASSERT_EQ(process.wait(), 0);
    }
    EXPECT_GT(read_file(folder / "a/events.csv").size(), 1000U);
    EXPECT_GT(read_file(folder / "a/force.csv").size(), 100'000U);
    EXPECT_EQ(read_file(folder / "a/events.csv"), read_file(folder / "b/events.csv"));
    EXPECT_EQ(read_file(folder / "a/force.csv"), read_file(folder / "b/force.csv"));
}

TEST(Program, PlansEveryExample) {
    for (const char* name : {"grasp", "paper", "recorded", "two_channels"}) {
        Process process({"plan", examples + name + ".txtpb", "--json"});
        ASSERT_EQ(process.wait(), 0) << process.err();
        const Json plan = Json::parse(process.out());
        EXPECT_EQ(plan.at("threads"), 1) << name;
        EXPECT_GT(plan.at("events_per_second_at_most"), 0) << name;
    }
}

TEST(Program, TunesASceneThatThenMeetsItsTarget) {
    const Folder folder;
    Process tune({"tune", examples + "grasp.txtpb", "--out", folder("tuned.txtpb"), "--json"});
    ASSERT_EQ(tune.wait(), 0) << tune.err();
    const Json tuned = Json::parse(tune.out());
    int at_full_scale = 0;
    for (const Json& patch : tuned.at("patches")) {
        EXPECT_EQ(patch.at("residual_hz"), 0.0) << "what is left is rounding";
        for (const Json& row : patch.at("table")) {
            if (row.at("grip_n") == 20.0) {
                EXPECT_NEAR(row.at("steady_hz").get<double>(), 100, 1e-9);
                ++at_full_scale;
            }
            EXPECT_GE(row.at("onset_hz").get<double>() + 1e-9, row.at("steady_hz").get<double>());
        }
    }
    EXPECT_EQ(at_full_scale, 3) << "once for each patch";
    // The written scene is tuned: it gives the same run.
    for (const auto& [scene, out] :
         {std::pair{examples + "grasp.txtpb", "a"}, {folder("tuned.txtpb"), "b"}}) {
        Process run({"run", scene, "--out", folder(out)});
        ASSERT_EQ(run.wait(), 0) << run.err();
    }
    EXPECT_GT(read_file(folder / "a/events.csv").size(), 1000U);
    EXPECT_EQ(read_file(folder / "a/events.csv"), read_file(folder / "b/events.csv"));
}

TEST(Program, WritesNoTunedSceneUnasked) {
    const Folder folder;
    std::filesystem::copy(examples + "grasp.txtpb", folder / "grasp.txtpb");
    Process tune({"tune", folder("grasp.txtpb")});
    ASSERT_EQ(tune.wait(), 0) << tune.err();
    const std::string table = "An afferent that feels the mean share of its patch (thumb, index, middle):";
    EXPECT_NE(tune.out().find(table), std::string::npos) << tune.out();
    EXPECT_EQ(tune.out().find("steady_hz"), tune.out().rfind("steady_hz")) << "one table for all";
    EXPECT_NE(tune.out().find("Nothing is written; --out"), std::string::npos);
    const std::filesystem::directory_iterator files(folder / "");
    EXPECT_EQ(std::distance(begin(files), end(files)), 1);
}

TEST(Program, FiresNoFasterThanThePaperAtItsMaximum) {
    Process tune({"tune", examples + "paper.txtpb", "--json"});
    ASSERT_EQ(tune.wait(), 0) << tune.err();
    const Json told = Json::parse(tune.out());
    int at_full_scale = 0;
    for (const Json& row : told.at("patches").at(0).at("table")) {
        if (row.at("grip_n") == 20.0) {
            EXPECT_NEAR(row.at("onset_hz").get<double>(), 100, 1e-9);
            ++at_full_scale;
        }
    }
    EXPECT_EQ(at_full_scale, 1);
}

TEST(Program, KeepsTheColumnsOfAPlanApart) {
    const Folder folder;
    const std::string name(70, 'x');
    const auto scene = write_file(folder / "s.txtpb", "patch { name: '" + name + "' }");
    Process plan({"plan", scene.string()});
    ASSERT_EQ(plan.wait(), 0) << plan.err();
    const std::string out = plan.out();
    EXPECT_NE(out.find(name), std::string::npos);
    EXPECT_TRUE(std::regex_search(out, std::regex(name + "\": sensors\n {8,}3 elements"))) << out;
}

TEST(Program, PrintsResultsAsJsonToo) {
    for (const auto& command : std::vector<std::vector<std::string>>{{"run"},
                                                                     {"plan"},
                                                                     {"tune"},
                                                                     {"coprocessor"},
                                                                     {"hand"},
                                                                     {"channel"},
                                                                     {"link", "status"},
                                                                     {"keys"},
                                                                     {"replay"},
                                                                     {"neuron"}}) {
        auto arguments = command;
        arguments.push_back("--help");
        Process help(arguments);
        EXPECT_EQ(help.wait(), 0);
        EXPECT_NE(help.out().find("--json"), std::string::npos) << command.back();
    }
    const Folder folder;
    Process keys({"keys", folder("keys"), "--json"});
    ASSERT_EQ(keys.wait(), 0) << keys.err();
    const Json made = Json::parse(keys.out());
    for (const char* const link_end : {"coprocessor", "hand"}) {
        EXPECT_FALSE(made.at(link_end).empty()) << link_end;
        for (const std::string file : made.at(link_end))
            EXPECT_TRUE(std::filesystem::exists(folder / "keys" / file)) << file;
    }
    const auto drive = write_file(folder / "drive.csv", "time_s,drive_mv\n0,45\n1,45\n");
    Process neuron({"neuron", "--drive", drive.string(), "--json"});
    ASSERT_EQ(neuron.wait(), 0) << neuron.err();
    EXPECT_GT(Json::parse(neuron.out())["spikes"].size(), 10U);
}

TEST(Program, SaysErrorsAsJsonToo) {
    for (const auto& [arguments, said] :
         {std::pair{std::vector<std::string>{"run", "no_such.txtpb"}, "no_such.txtpb"},
          {{"run", examples + "grasp.txtpb", "--seed", "-1"}, "--seed: must be >= 0, is -1"},
          {{"run", examples + "grasp.txtpb", "--sed", "1"},
           "there is no option --sed; did you mean --seed?"}}) {
        auto with_json = arguments;
        with_json.push_back("--json");
        Process process(with_json);
        EXPECT_NE(process.wait(), 0);
        const Json told = Json::parse(process.err());
        EXPECT_NE(told.at("error").get<std::string>().find(said), std::string::npos) << told;
    }
}

TEST(Program, RefusesATuningThatCannotBe) {
    const Folder folder;
    const auto scene = write_file(folder / "s.txtpb", "every_patch { neuron { refractory_ms: 20 } }");
    Process process({"tune", scene.string()});
    EXPECT_EQ(process.wait(), 1);
    EXPECT_NE(process.err().find("refractory period"), std::string::npos) << process.err();
}

// A table that is wrong in one way, and what the program must say of it.
struct BadTable {
    const char* what;
    std::string text;
    const char* said;
};

class BadTables : public testing::TestWithParam<BadTable> {};

TEST_P(BadTables, AreRefusedWithFileAndLine) {
    const Folder folder;
    const auto table = write_file(folder / "force.csv", GetParam().text);
    const auto scene = write_file(folder / "s.txtpb", R"(duration_s: 1 link { tcp {} }
        source { table { path: "force.csv" column: "force_n" out_of_range: REFUSE } })");
    Process process({"run", scene.string(), "--out", folder("out")});
    EXPECT_EQ(process.wait(), 1);
    EXPECT_NE(process.err().find(GetParam().said), std::string::npos) << process.err();
    EXPECT_NE(process.err().find("force.csv"), std::string::npos) << process.err();
}

INSTANTIATE_TEST_SUITE_P(
    Program, BadTables,
    testing::Values(BadTable{"empty", "", "empty"}, BadTable{"header_only", "time_s,force_n\n", "no rows"},
                    BadTable{"missing_column", "time_s,f_n\n0,1\n", ":1: there is no column \"force_n\""},
                    BadTable{"not_a_number", "time_s,force_n\n0,1\n0.1,x\n", ":3: "},
                    BadTable{"nan", "time_s,force_n\n0,nan\n", ":2: "},
                    BadTable{"infinite", "time_s,force_n\n0,1\n0.1,inf\n", ":3: "},
                    BadTable{"time_backwards", "time_s,force_n\n0.1,1\n0.05,1\n", ":3: "},
                    BadTable{"truncated", "time_s,force_n\n0,1", ":2: the last line is cut off"},
                    BadTable{"negative", "time_s,force_n\n0,1\n0.1,-1\n", ":3: negative"},
                    BadTable{"beyond_scale", "time_s,force_n\n0,1\n0.1,500\n", ":3: beyond the full scale"}),
    [](const auto& bad) { return std::string(bad.param.what); });

TEST(Program, ClipsAndCountsWhereTheSceneSaysSo) {
    const Folder folder;
    write_file(folder / "force.csv", "time_s,force_n\n0,1\n0.1,-1\n0.2,500\n");
    const auto scene = write_file(folder / "s.txtpb", R"(duration_s: 1
        source { table { path: "force.csv" out_of_range: CLIP between: HOLD } })");
    Process process({"run", scene.string(), "--json"});
    EXPECT_EQ(process.wait(), 0) << process.err();
    const Json summary = Json::parse(process.out());
    EXPECT_EQ(summary["clipped_samples"], 18) << "nine elements, twice";
    EXPECT_NE(summary["notes"].dump().find("beyond full scale, and read as that"), std::string::npos)
        << summary["notes"].dump();
}

TEST(Program, RefusesATableWithFewerColumnsThanElements) {
    const Folder folder;
    write_file(folder / "force.csv", "time_s,a_n,b_n\n0,1,1\n");
    const auto scene = write_file(folder / "s.txtpb", R"(source { table { path: "force.csv" } })");
    Process process({"run", scene.string()});
    EXPECT_EQ(process.wait(), 1);
    EXPECT_NE(process.err().find("the scene has 9 elements"), std::string::npos) << process.err();
}

TEST(Program, ConvertsEventsToEveryFormatAndBack) {
    const Folder folder;
    Process run({"run", examples + "grasp.txtpb", "--out", folder("out"), "--record", folder("r.afferent")});
    ASSERT_EQ(run.wait(), 0) << run.err();
    // Microseconds, where a format has no finer ones.
    Process exact({"convert", folder("out/events.csv"), folder("us.es")});
    ASSERT_EQ(exact.wait(), 0) << exact.err();
    Process back({"convert", folder("us.es"), folder("us.csv")});
    ASSERT_EQ(back.wait(), 0) << back.err();
    for (const auto& [name, equal] :
         {std::pair{"a.sonata.h5", "out/events.csv"}, {"a.nwb", "out/events.csv"}, {"a.aedat", "us.csv"}}) {
        Process there({"convert", folder("out/events.csv"), folder(name)});
        EXPECT_EQ(there.wait(), 0) << there.err();
        Process again({"convert", folder(name), folder("again.csv")});
        EXPECT_EQ(again.wait(), 0) << again.err();
        EXPECT_GT(read_file(folder / equal).size(), 1000U) << equal;
        EXPECT_EQ(read_file(folder / "again.csv"), read_file(folder / equal)) << name;
    }
    Process recorded({"convert", folder("r.afferent"), folder("r.nwb"), "--json"});
    EXPECT_EQ(recorded.wait(), 0) << recorded.err();
    const Json converted = Json::parse(recorded.out());
    EXPECT_EQ(converted.at("to"), folder("r.nwb"));
    EXPECT_GT(converted.at("events"), 100);
    EXPECT_LT(converted.at("first_s").get<double>(), converted.at("last_s").get<double>());
    EXPECT_EQ(converted.at("patches").dump(), R"([{"afferents":3,"kind":"sustained","name":"thumb"},)"
                                              R"({"afferents":3,"kind":"sustained","name":"index"},)"
                                              R"({"afferents":3,"kind":"sustained","name":"middle"}])");
    Process wrong({"convert", folder("out/events.csv"), folder("a.mat")});
    EXPECT_EQ(wrong.wait(), 1);
    EXPECT_NE(wrong.err().find(".nwb"), std::string::npos) << wrong.err();
    Process truncated({"convert", folder("out/force.csv"), folder("b.nwb")});
    EXPECT_EQ(truncated.wait(), 1);
}

TEST(Program, ReadsStandardInput) {
    const Folder folder;
    const auto scene = write_file(folder / "s.txtpb", "duration_s: 1 source { standard_input {} }");
    Process process({"run", scene.string(), "--json"}, "time_s,force_n\n0,0\n0.2,8\n0.6,0\n");
    EXPECT_EQ(process.wait(), 0) << process.err();
    EXPECT_GT(Json::parse(process.out())["events"], 50);
}

TEST(Program, SaysWhereASceneIsWrong) {
    const Folder folder;
    const auto scene = write_file(folder / "scene.txtpb", "\n\nevery_patch {\n  neuron { tau_m_ms: 0 }\n}\n");
    Process process({"run", scene.string()});
    EXPECT_EQ(process.wait(), 1);
    EXPECT_NE(
        process.err().find("scene.txtpb:4:12: patch \"thumb\": neuron.tau_m_ms must be 1e-6 to 1e6, is 0"),
        std::string::npos)
        << process.err();
}

TEST(Program, SaysThatItCannotWrite) {
    const Folder folder;
    write_file(folder / "file", "");
    Process nowhere({"run", examples + "grasp.txtpb", "--out", folder("file") + "/out"});
    EXPECT_EQ(nowhere.wait(), 1);
    EXPECT_NE(nowhere.err().find("file/out"), std::string::npos) << nowhere.err();
}

TEST(Program, SaysThatTheDiskIsFull) {
    if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
    const Folder folder;
    std::filesystem::create_directory(folder / "out");
    std::filesystem::create_symlink("/dev/full", folder / "out/force.csv");
    Process process({"run", examples + "grasp.txtpb", "--out", folder("out")});
    EXPECT_EQ(process.wait(), 1);
    EXPECT_NE(process.err().find("force.csv"), std::string::npos) << process.err();
    EXPECT_FALSE(std::filesystem::exists(folder / "out/summary.json"));
}

TEST(Program, EndsCleanlyOnCtrlC) {
    const Folder folder;
    Process process({"run", examples + "grasp.txtpb", "--realtime", "--out", folder("out"), "--json"});
    ASSERT_TRUE(comes_true([&] { return has_begun_in(folder / "out"); })) << process.err();
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    process.signal(SIGINT);
    EXPECT_EQ(process.wait(), 130);
    const Json summary = Json::parse(process.out());
    EXPECT_EQ(summary.at("interrupted"), true);
    EXPECT_LT(summary.at("duration_s").get<double>(), 10);
    EXPECT_TRUE(std::filesystem::exists(folder / "out/events.csv"));
}

}  // namespace
}  // namespace afferent
