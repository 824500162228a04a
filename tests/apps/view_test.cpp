// The view's command line: who may ask for it, at which address, and how it ends.
#include <gtest/gtest.h>

#include <regex>

#include "tests/apps/process.hpp"

namespace afferent {
namespace {

// The address of the view that the process has told of.
std::string view_of(Process& process) {
    EXPECT_TRUE(process.has_said("view: http://127.0.0.1:")) << process.err();
    std::smatch found;
    const std::string said = process.err();
    return std::regex_search(said, found, std::regex("view: (http://127[.]0[.]0[.]1:[0-9]+/[0-9a-f]{32}/)\n"))
               ? found[1].str()
               : "";
}

std::string view_port() { return std::to_string(31'000 + ::getpid() % 1'000); }

TEST(ViewCommand, WaitsForAViewerAndEndsWithCtrlC) {
    Process view({"view", examples + "grasp.txtpb"});
    EXPECT_NE(view_of(view), "");
    EXPECT_TRUE(view.has_said("begins once a browser shows this page"));
    view.signal(SIGINT);
    EXPECT_EQ(view.wait(), 130) << view.err();
}

TEST(ViewCommand, ShowsARecordingAndTheHandOfALink) {
    const Folder folder;
    const std::string recording = folder("g.afferent");
    Process run({"run", examples + "grasp.txtpb", "--duration", "0.2", "--record", recording});
    ASSERT_EQ(run.wait(), 0) << run.err();
    Process view({"view", recording, "--speed", "2"});
    EXPECT_NE(view_of(view), "");
    view.signal(SIGTERM);
    EXPECT_EQ(view.wait(), 130) << view.err();

    const auto scene =
        write_file(folder / "s.txtpb", "link { unix_socket { path: \"hand.sock\" } }").string();
    Process hand({"view", scene, "--link"});
    EXPECT_NE(view_of(hand), "");
    EXPECT_TRUE(hand.has_said("waiting for the coprocessor")) << hand.err();
    hand.signal(SIGINT);
    EXPECT_EQ(hand.wait(), 130) << hand.err();
}

TEST(ViewCommand, SaysWhatDoesNotGoTogether) {
    const std::string scene = examples + "grasp.txtpb";
    const std::vector<std::pair<std::vector<std::string>, const char*>> wrong{
        {{"run", scene, "--view"},
         "--view: shows a run as it happens, at the wall clock's pace: add --realtime"},
        {{"run", scene, "--view-port", "8123"}, "add --realtime"},
        {{"view", scene, "--speed", "2"}, "--speed, --from-s: are for recordings"},
        {{"view", "g.afferent", "--link"}, "--link: a recording has none"},
        {{"view", "g.afferent", "--set", "seed=2"}, "a recording is shown as it was"},
        {{"view", "absent.afferent"}, "absent.afferent"},
        {{"view", "absent.txtpb"}, "absent.txtpb"},
        {{"replay", "g.afferent", "--fast", "--view"},
         "--view: shows a replay at a pace to follow: not with --fast"},
        {{"run", scene, "--realtime", "--view-port", "70000"}, "70000"},
    };
    for (const auto& [arguments, text] : wrong) {
        Process process(arguments);
        EXPECT_GT(process.wait(), 0);
        EXPECT_NE((process.out() + process.err()).find(text), std::string::npos) << process.err();
    }
}

TEST(ViewCommand, KeepsItsAddressWhereThePortIsGiven) {
    const Folder folder;
    ::setenv("XDG_RUNTIME_DIR", folder("").c_str(), 1);
    std::string first;
    for (int i = 0; i < 2; ++i) {
        Process view({"view", examples + "grasp.txtpb", "--view-port", view_port()});
        const std::string url = view_of(view);
        EXPECT_NE(url.find(":" + view_port() + "/"), std::string::npos) << url;
        if (i == 1) {
            EXPECT_EQ(url, first);
            // Two cannot have the same.
            Process second({"view", examples + "grasp.txtpb", "--view-port", view_port()});
            EXPECT_EQ(second.wait(), 1);
            EXPECT_NE(second.err().find("port " + view_port() + " on 127.0.0.1: Address already in use"),
                      std::string::npos)
                << second.err();
        }
        first = url;
        view.signal(SIGINT);
        EXPECT_EQ(view.wait(), 130) << view.err();
    }
    const auto token = folder / "afferent" / ("view-" + view_port());
    EXPECT_EQ(std::filesystem::status(token).permissions(),
              std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
    ::unsetenv("XDG_RUNTIME_DIR");
}

}  // namespace
}  // namespace afferent
