// Outputs that take nothing, or nothing more: a hand goes on, and says what it could not write.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/apps/process.hpp"

namespace afferent {
namespace {

using Json = nlohmann::json;

std::string grasp(const std::string& more = "") {
    return R"(
        duration_s: 1.5 link { unix_socket { path: "hand.sock" } )" +
           patient + R"( }
        hand { user { close_at_s: 0.1 close_for_s: 1.2 hold_for_s: 0.1 open_for_s: 0.1 effort: 0.7 }
               object { distance_mm: 5 stiffness_n_per_mm: 1 } } )" +
           more;
}

// The program as a line of the shell says it, where $0 is the program and $1, $2 ... are the arguments.
class ShellProcess : public Process {
  public:
    ShellProcess(const std::string& line, std::vector<std::string> arguments)
        : Process(with(line, std::move(arguments)), "", "/bin/sh") {}

  private:
    static std::vector<std::string> with(const std::string& line, std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), {"-c", line, AFFERENT_PROGRAM});
        return arguments;
    }
};

// A named pipe that is full, and that nobody reads.
class FullPipe {
  public:
    explicit FullPipe(const std::filesystem::path& path) {
        EXPECT_EQ(::mkfifo(path.c_str(), 0600), 0);
        file_ = ::open(path.c_str(), O_RDWR | O_NONBLOCK);
        EXPECT_GE(file_, 0);
        const std::string page(4096, '\n');
        while (::write(file_, page.data(), page.size()) > 0) {
        }
    }
    ~FullPipe() { ::close(file_); }
    FullPipe(const FullPipe&) = delete;
    FullPipe& operator=(const FullPipe&) = delete;

  private:
    int file_;
};

// The other end, whose session is not harmed.
void expect_whole_session(const std::string& scene) {
    Process coprocessor({"coprocessor", scene});
    EXPECT_EQ(coprocessor.wait(), 0) << coprocessor.err();
}

TEST(Outputs, ATerminalThatTakesNothingHoldsNothingUp) {
    const Folder folder;
    const auto scene = write_file(folder / "s.txtpb", grasp()).string();
    const FullPipe terminal(folder / "terminal");
    ShellProcess hand("exec \"$0\" hand \"$1\" --json 2>\"$2\"", {scene, folder("terminal")});
    expect_whole_session(scene);
    EXPECT_EQ(hand.wait(), 0);
    const Json summary = Json::parse(hand.out());
    EXPECT_EQ(summary.at("complete"), true);
    EXPECT_EQ(summary.at("sessions"), 1);
    EXPECT_EQ(summary.at("unwritten_steps"), 0);
    // The system decides which of them.
    EXPECT_TRUE(summary.at("memory_locked").is_boolean());
}

TEST(Outputs, ATerminalThatTakesNothingKeepsNoFailureFromItsEnd) {
    const Folder folder;
    const FullPipe terminal(folder / "terminal");
    ShellProcess plan("exec \"$0\" plan \"$1\" 2>\"$2\"", {folder("no.txtpb"), folder("terminal")});
    EXPECT_EQ(plan.wait(), 1);
}

TEST(Outputs, APipeThatTakesNothingCostsItsStepsAndNothingElse) {
    const Folder folder;
    const FullPipe motor(folder / "motor");
    const auto scene =
        write_file(folder / "s.txtpb", grasp("output { command_file { path: 'motor' } }")).string();
    Process hand({"hand", scene, "--json", "--out", folder("out"), "--record", folder("recording")});
    expect_whole_session(scene);
    EXPECT_EQ(hand.wait(), 1);
    EXPECT_NE(hand.err().find(" steps were not recorded"), std::string::npos) << hand.err();
    EXPECT_NE(hand.err().find("motor: has taken nothing for a second"), std::string::npos) << hand.err();
    const Json summary = Json::parse(hand.out());
    EXPECT_EQ(summary.at("complete"), true);
    EXPECT_EQ(summary.at("sessions"), 1);
    EXPECT_EQ(summary.at("unwritten_steps"), 1500);
    EXPECT_GT(summary.at("events"), 50);
    // All the others are whole.
    for (const char* table : {"out/force.csv", "out/emg.csv"}) {
        const std::string rows = read_file(folder / table);
        EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n'), 1501) << table;
    }
    Process replay({"replay", folder("recording"), "--json"});
    EXPECT_EQ(replay.wait(), 0) << replay.err();
    EXPECT_EQ(Json::parse(replay.out())["until_s"], 1.499) << replay.out();
}

TEST(Outputs, APipeThatNobodyReadsIsNotWaitedFor) {
    const Folder folder;
    ASSERT_EQ(::mkfifo(folder("motor").c_str(), 0600), 0);
    const auto scene =
        write_file(folder / "s.txtpb", grasp("output { command_file { path: 'motor' } }")).string();
    Process hand({"hand", scene, "--json"});
    ASSERT_TRUE(hand.has_said("motor: nobody reads this pipe")) << hand.err();
    ASSERT_TRUE(hand.has_said("waiting for the coprocessor")) << hand.err();
    expect_whole_session(scene);
    EXPECT_EQ(hand.wait(), 1);
    EXPECT_EQ(Json::parse(hand.out())["unwritten_steps"], 1500) << hand.err();
}

TEST(Outputs, APipesReaderMayComeLate) {
    const Folder folder;
    ASSERT_EQ(::mkfifo(folder("motor").c_str(), 0600), 0);
    const auto scene =
        write_file(folder / "s.txtpb", grasp("output { command_file { path: 'motor' } }")).string();
    Process hand({"hand", scene, "--json"});
    ASSERT_TRUE(hand.has_said("nobody reads")) << hand.err();
    Process reader({"-c", "cat \"$0\"", folder("motor")}, "", "/bin/sh");
    expect_whole_session(scene);
    hand.wait();
    reader.wait();
    const std::string read = reader.out();
    EXPECT_EQ(read.rfind("time_s,force_n,sigma_n,gain,command,doubt\n", 0), 0U) << read.substr(0, 100);
    const auto rows = std::count(read.begin(), read.end(), '\n') - 1;
    EXPECT_GT(rows, 100);
    EXPECT_EQ(Json::parse(hand.out())["unwritten_steps"], 1500 - rows) << hand.err();
}

// A limit on the size of files stands for a full disk.
TEST(Outputs, AFullDiskCostsItsStepsAndNothingElse) {
    const Folder folder;
    const auto scene = write_file(folder / "s.txtpb", grasp("record { picture: false }")).string();
    ShellProcess hand("trap '' XFSZ; ulimit -f 16; exec \"$0\" hand \"$1\" --json --out \"$2\"",
                      {scene, folder("out")});
    expect_whole_session(scene);
    EXPECT_EQ(hand.wait(), 1);
    EXPECT_NE(hand.err().find(" steps were not recorded"), std::string::npos) << hand.err();
    EXPECT_NE(hand.err().find("force.csv"), std::string::npos) << hand.err();
    EXPECT_NE(hand.err().find("what there is of it stays in " + folder("out/unfinished-")), std::string::npos)
        << hand.err();
    const Json summary = Json::parse(hand.out());
    EXPECT_EQ(summary.at("complete"), true);
    EXPECT_GT(summary.at("unwritten_steps"), 500);
}

TEST(Outputs, AFullStandardOutputIsAFailureOfEveryCommand) {
    const Folder folder;
    const auto scene = write_file(folder / "s.txtpb", "duration_s: 0.1").string();
    for (const std::string line : {"run \"$1\"", "run \"$1\" --json", "plan \"$1\"", "plan \"$1\" --json",
                                   "--help", "tune \"$1\" --json", "neuron --help"}) {
        ShellProcess process("exec \"$0\" " + line + " >/dev/full", {scene});
        EXPECT_EQ(process.wait(), 1) << line << process.err();
        EXPECT_NE(process.err().find("standard output: cannot be written"), std::string::npos)
            << line << process.err();
    }
}

TEST(Outputs, AHandWhoseStandardOutputIsFullFails) {
    const Folder folder;
    const auto scene = write_file(folder / "s.txtpb", grasp()).string();
    ShellProcess hand("exec \"$0\" hand \"$1\" --json >/dev/full", {scene});
    expect_whole_session(scene);
    EXPECT_EQ(hand.wait(), 1);
    EXPECT_NE(hand.err().find("standard output: cannot be written"), std::string::npos) << hand.err();
}

TEST(Outputs, AreCompletedWhenTheTerminalGoes) {
    const Folder folder;
    const auto scene = write_file(folder / "s.txtpb", grasp("record { picture: false }")).string();
    Process hand({"hand", scene, "--json", "--out", folder("out")});
    Process coprocessor({"coprocessor", scene});
    ASSERT_TRUE(coprocessor.has_said("the hand is there"));
    hand.signal(SIGHUP);
    EXPECT_EQ(hand.wait(), 130) << hand.err();
    EXPECT_EQ(Json::parse(hand.out())["complete"], false);
    EXPECT_TRUE(std::filesystem::exists(folder / "out/summary.json"));
    EXPECT_EQ(coprocessor.wait(), 1);
}

}  // namespace
}  // namespace afferent
