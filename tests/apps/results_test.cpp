// The files that a run leaves in its folder of results.
#include <map>

#include "tests/apps/process.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

std::string scene_of(const std::string& table, int duration_s, bool events = true) {
    return "duration_s: " + std::to_string(duration_s) +
           " record { picture: false events: " + (events ? "true" : "false") +
           " } source { table { path: \"" + table + "\" out_of_range: REFUSE } }";
}

class Results : public testing::Test {
  protected:
    Results() {
        write_file(folder_ / "good.csv", "time_s,force_n\n0,1\n0.1,4\n");
        write_file(folder_ / "bad.csv", "time_s,force_n\n0,1\n0.1,4\n0.2,x\n");
        write_file(folder_ / "good.txtpb", scene_of("good.csv", 1));
        Process run({"run", folder_("good.txtpb"), "--out", folder_("out")});
        EXPECT_EQ(run.wait(), 0) << run.err();
        summary_ = read_file(folder_ / "out/summary.json");
        events_ = read_file(folder_ / "out/events.csv");
        EXPECT_NE(summary_, "");
        EXPECT_NE(events_, "");
        EXPECT_EQ(unfinished(), 0U);
    }

    std::size_t unfinished() const {
        std::size_t count = 0;
        for (const auto& entry : fs::directory_iterator(folder_ / "out"))
            if (entry.path().filename().string().starts_with("unfinished-")) ++count;
        return count;
    }

    void expect_the_old_ones() const {
        EXPECT_EQ(read_file(folder_ / "out/summary.json"), summary_);
        EXPECT_EQ(read_file(folder_ / "out/events.csv"), events_);
    }

    const Folder folder_;
    std::string summary_;
    std::string events_;
};

TEST_F(Results, OfTheRunBeforeStayWhereOneFails) {
    write_file(folder_ / "bad.txtpb", scene_of("bad.csv", 1));
    Process run({"run", folder_("bad.txtpb"), "--out", folder_("out")});
    EXPECT_EQ(run.wait(), 1);
    EXPECT_NE(run.err().find("bad.csv:4: "), std::string::npos) << run.err();
    expect_the_old_ones();
    EXPECT_EQ(unfinished(), 0U);
}

TEST_F(Results, OfTheRunBeforeStayWhereOneIsKilled) {
    write_file(folder_ / "long.txtpb", scene_of("good.csv", 3600));
    Process run({"run", folder_("long.txtpb"), "--realtime", "--out", folder_("out")});
    ASSERT_TRUE(comes_true([&] { return unfinished() == 1; })) << run.err();
    run.signal(SIGKILL);
    EXPECT_EQ(run.wait(), -SIGKILL);
    expect_the_old_ones();
    EXPECT_EQ(unfinished(), 1U) << "what it had recorded";
}

TEST_F(Results, OfARunThatWritesLessTakeThePlaceOfAll) {
    write_file(folder_ / "less.txtpb", scene_of("good.csv", 1, false));
    Process run({"run", folder_("less.txtpb"), "--out", folder_("out")});
    EXPECT_EQ(run.wait(), 0) << run.err();
    EXPECT_FALSE(fs::exists(folder_ / "out/events.csv")) << "it was of the run before";
    EXPECT_TRUE(fs::exists(folder_ / "out/summary.json"));
}

class ResultsOfTwoSides : public testing::Test {
  protected:
    ResultsOfTwoSides() {
        write_scene("short.txtpb", 1);
        write_scene("long.txtpb", 600);
        Process hand({"hand", folder_("short.txtpb"), "--out", folder_("hand")});
        Process coprocessor({"coprocessor", folder_("short.txtpb"), "--out", folder_("coprocessor")});
        EXPECT_EQ(coprocessor.wait(), 0) << coprocessor.err();
        EXPECT_EQ(hand.wait(), 0) << hand.err();
        before_ = files();
        EXPECT_EQ(before_.size(), 5U) << "emg.csv, events.csv, force.csv, two of summary.json";
    }

    void write_scene(const std::string& name, int duration_s) {
        write_file(folder_ / name, "duration_s: " + std::to_string(duration_s) +
                                       " record { picture: false } link { unix_socket { path: 's.sock' } " +
                                       patient + " }");
    }

    // All files but unfinished ones, with their contents.
    std::map<std::string, std::string> files() const {
        std::map<std::string, std::string> found;
        for (const char* link_end : {"hand", "coprocessor"})
            for (const auto& entry : fs::directory_iterator(folder_ / link_end))
                if (entry.is_regular_file()) found[entry.path()] = read_file(entry.path());
        return found;
    }

    std::string unfinished(const char* link_end) const {
        for (const auto& entry : fs::directory_iterator(folder_ / link_end))
            if (entry.is_directory()) return entry.path();
        return "";
    }

    const Folder folder_;
    std::map<std::string, std::string> before_;
};

TEST_F(ResultsOfTwoSides, OfTheSessionBeforeStayWhereTheyAreKilled) {
    Process hand({"hand", folder_("long.txtpb"), "--out", folder_("hand")});
    Process coprocessor({"coprocessor", folder_("long.txtpb"), "--out", folder_("coprocessor")});
    ASSERT_TRUE(coprocessor.has_said("the hand is there"));
    ASSERT_TRUE(comes_true([&] { return unfinished("hand") != "" && unfinished("coprocessor") != ""; }));
    hand.signal(SIGKILL);
    coprocessor.signal(SIGKILL);
    EXPECT_EQ(hand.wait(), -SIGKILL);
    EXPECT_EQ(coprocessor.wait(), -SIGKILL);
    EXPECT_EQ(files(), before_);
    EXPECT_NE(unfinished("hand"), "") << "what it had recorded";
    EXPECT_NE(unfinished("coprocessor"), "");
}

TEST_F(ResultsOfTwoSides, OfASessionThatIsInterruptedTakeThePlaceOfAll) {
    Process hand({"hand", folder_("long.txtpb"), "--out", folder_("hand")});
    Process coprocessor({"coprocessor", folder_("long.txtpb"), "--out", folder_("coprocessor")});
    ASSERT_TRUE(coprocessor.has_said("the hand is there"));
    hand.signal(SIGINT);
    EXPECT_EQ(hand.wait(), 130) << hand.err();
    EXPECT_EQ(coprocessor.wait(), 1);
    const auto after = files();
    EXPECT_EQ(after.size(), before_.size());
    // The tables of the shortest session may be empty both times, so only the summaries must differ.
    for (const auto& [name, content] : before_)
        if (fs::path(name).filename() == "summary.json") {
            EXPECT_NE(after.at(name), content) << name;
        }
    EXPECT_EQ(unfinished("hand"), "");
    EXPECT_EQ(unfinished("coprocessor"), "");
}

}  // namespace
}  // namespace afferent
