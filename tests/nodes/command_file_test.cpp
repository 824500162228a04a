// The output that writes commands to a file.
#include "afferent/nodes/command_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "afferent/nodes/hello.hpp"
#include "afferent/nodes/replay.hpp"
#include "afferent/nodes/run.hpp"
#include "tests/nodes/two_nodes.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

class CommandFiles : public testing::Test {
  protected:
    CommandFiles()
        : file_(fs::temp_directory_path() / ("afferent-" + std::to_string(getpid()) + ".commands.csv")) {}
    ~CommandFiles() override { fs::remove(file_); }

    Scene grasp() const {
        Scene scene;
        scene.duration_s = 2;
        scene.output = {scene::CommandFile{file_.string()}};
        return scene;
    }

    fs::path file_;
};

TEST_F(CommandFiles, HaveARowForEachStep) {
    const Plan plan = make_plan(grasp());
    std::vector<double> commands;
    std::vector<std::string> doubts;
    const auto opened = afferent::Run::open(plan, {.step = [&](const ControllerStep& step) {
                                                commands.push_back(step.command);
                                                doubts.emplace_back(name(step.estimate.doubt));
                                            }});
    ASSERT_TRUE(opened) << opened.error().text;
    afferent::Run& run = *opened.value();
    while (!run.done()) ASSERT_TRUE(run.do_next());
    run.finish(plan.end());
    ASSERT_TRUE(run.close());

    std::ifstream in(file_);
    std::string line;
    ASSERT_TRUE(std::getline(in, line));
    EXPECT_EQ(line, "time_s,force_n,sigma_n,gain,command,doubt");
    std::vector<double> written;
    std::vector<std::string> written_doubts;
    while (std::getline(in, line)) {
        const std::size_t last = line.rfind(',');
        written_doubts.push_back(line.substr(last + 1));
        written.push_back(std::stod(line.substr(line.rfind(',', last - 1) + 1)));
    }
    EXPECT_EQ(written.size(), 2000U);
    EXPECT_EQ(written, commands);
    EXPECT_EQ(written_doubts, doubts);
    EXPECT_EQ(doubts.at(0), "unknown") << "no packet has come";
}

TEST_F(CommandFiles, ComeFromAReplayThatAsksForThem) {
    Scene scene = grasp();
    scene.link.transport = scene::Tcp();
    const Plan plan = make_plan(scene);
    const fs::path recording = file_.string() + ".afferent";
    const auto run = value_or_throw(afferent::Run::open(plan, {}));
    value_or_throw(run->record(recording, make_hello(plan, true)));
    while (!run->done()) value_or_throw(run->do_next());
    run->finish(plan.end());
    value_or_throw(run->close());
    const auto content = [&] {
        std::ifstream in(file_);
        return std::string(std::istreambuf_iterator<char>(in), {});
    };
    const std::string written = content();
    ASSERT_GT(written.size(), 2000U);
    fs::remove(file_);
    const auto replay = value_or_throw(Replay::open(recording, {}, {}, &scene));
    while (value_or_throw(replay->next())) replay->step();
    value_or_throw(replay->close());
    EXPECT_EQ(content(), written);
    fs::remove(recording);
}

// In lockstep the node would wait for a reader.
TEST_F(CommandFiles, DoNotHoldUpAHandWhereNobodyReadsTheirPipe) {
    ASSERT_EQ(::mkfifo(file_.c_str(), 0600), 0);
    TwoNodes two(press("", 2, "output { command_file { path: '" + file_.string() + "' } } "));
    two.start_hand();
    EXPECT_EQ(
        two.hand.node->output_notices(),
        std::vector{file_.string() + ": nobody reads this pipe; until somebody does its rows are lost"});
    two.start_coprocessor();
    two.run_to_the_end();
    EXPECT_EQ(two.hand.steps.size(), 2000U);
    EXPECT_TRUE(two.hand.node->close());
    EXPECT_GT(two.hand.node->lost_steps(), 1000U);
    const auto another = CommandFile::open(two.plan.scene, {file_.string()}, FullPipe::lose_rows);
    ASSERT_TRUE(another) << another.error().text;
    EXPECT_EQ(another.value().lost().events, 0U) << "it writes none";
}

TEST_F(CommandFiles, AreRefusedWhereTheyCannotBeWritten) {
    Scene scene = grasp();
    scene.output = {scene::CommandFile{"/nowhere/commands.csv"}};
    const Plan plan = make_plan(scene);
    const auto run = afferent::Run::open(plan, {});
    ASSERT_FALSE(run);
    EXPECT_NE(run.error().text.find("/nowhere/commands.csv"), std::string::npos);
}

TEST_F(CommandFiles, AreNotWrittenWhereTheSceneDoesNotAskForThem) {
    Scene scene = grasp();
    scene.output.clear();
    const Plan plan = make_plan(scene);
    const auto run = afferent::Run::open(plan, {});
    ASSERT_TRUE(run);
    EXPECT_FALSE(fs::exists(file_));
}

}  // namespace
}  // namespace afferent
