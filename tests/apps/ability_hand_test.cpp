// An emulated Ability Hand on a pseudo-terminal, and the program that holds it, as a user would start them.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <regex>

#include "tests/apps/process.hpp"

namespace afferent {
namespace {

using Json = nlohmann::json;

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

// The example, in a folder of its own and with the patience of a busy machine.
std::string scene_in(const Folder& folder) {
    std::string text = replaced(read_file(examples + "ability_hand.txtpb"),
                                "tcp { host: \"127.0.0.1\" port: 7452 }", "unix_socket {} " + patient);
    text = replaced(text, "packet_ms: 1 delivery_ms: 1", "packet_ms: 5 delivery_ms: 20");
    return write_file(folder / "s.txtpb", text).string();
}

bool stands(Process& emulator) { return emulator.has_said("an emulated hand is at"); }

void hold_an_object(double& highest_grip_n) {
    const Folder folder;
    const std::string scene = scene_in(folder);
    Process emulator({"emulate", scene, "--json"});
    ASSERT_TRUE(stands(emulator)) << emulator.err();
    Process hand({"hand", scene, "--duration", "4", "--json"});
    EXPECT_EQ(hand.wait(), 0) << hand.err();
    const Json summary = Json::parse(hand.out());
    EXPECT_EQ(summary["complete"], true);
    EXPECT_GT(summary["events"], 10);
    EXPECT_GT(summary["hand"]["replies"], 100);
    EXPECT_EQ(summary["hand"]["lost_lines"], 0);
    emulator.signal(SIGINT);
    EXPECT_EQ(emulator.wait(), 0) << emulator.err();
    highest_grip_n = Json::parse(emulator.out())["highest_grip_n"];
    EXPECT_FALSE(std::filesystem::is_symlink(folder / "ability_hand.tty")) << "it takes its name with it";
}

// How hard, and whether it comes to that within four seconds, a busy machine decides, too: the limits are
// those of the driver's tests, in virtual time.
TEST(AbilityHandProgram, HoldsAnObject) {
    double highest_grip_n = 0;
    for (int tries = 0; tries < 4 && highest_grip_n < 0.5; ++tries) {
        ASSERT_NO_FATAL_FAILURE(hold_an_object(highest_grip_n));
    }
    EXPECT_GT(highest_grip_n, 0.5);
}

TEST(AbilityHandProgram, PrintsTheZeroOfItsSensors) {
    const Folder folder;
    const std::string scene = scene_in(folder);
    Process emulator({"emulate", scene});
    ASSERT_TRUE(stands(emulator)) << emulator.err();
    // A busy machine may give the emulator no turn within the second that the zero takes.
    std::optional<Process> zero;
    for (int tries = 0; tries < 8; ++tries) {
        zero.emplace(std::vector<std::string>{"hand", scene, "--zero"});
        if (zero->wait() == 0) break;
    }
    EXPECT_EQ(zero->wait(), 0) << zero->err();
    EXPECT_TRUE(std::regex_match(zero->out(), std::regex(R"(zero_counts: \[\d+(, \d+){29}\]\n)")))
        << zero->out();
    EXPECT_NE(zero->err().find("that is what they hide"), std::string::npos) << zero->err();
}

TEST(AbilityHandProgram, FindsAHandAgainThatWasGone) {
    const Folder folder;
    const std::string scene = scene_in(folder);
    Process hand({"hand", scene, "--json"});
    EXPECT_EQ(hand.wait(), 1);
    EXPECT_NE(hand.err().find("hand.ability_hand.port"), std::string::npos) << hand.err();
    EXPECT_NE(hand.err().find("afferent emulate"), std::string::npos) << hand.err();

    std::optional<Process> emulator;
    emulator.emplace(std::vector<std::string>{"emulate", scene});
    ASSERT_TRUE(stands(*emulator)) << emulator->err();
    Process other({"hand", scene, "--duration", "60", "--json"});
    ASSERT_TRUE(other.has_said("the coprocessor is there")) << other.err();
    emulator.reset();
    EXPECT_TRUE(other.has_said("the line to the hand has failed")) << other.err();
    emulator.emplace(std::vector<std::string>{"emulate", scene});
    EXPECT_TRUE(other.has_said("the line to the hand is there again")) << other.err();
    other.signal(SIGINT);
    EXPECT_NE(other.wait(), 0);
    EXPECT_EQ(Json::parse(other.out())["hand"]["lost_lines"], 1);
}

TEST(AbilityHandProgram, IsDrivenByNothingElse) {
    const Folder folder;
    Process run({"run", scene_in(folder)});
    EXPECT_EQ(run.wait(), 1);
    EXPECT_NE(run.err().find("`afferent hand` drives it"), std::string::npos) << run.err();
    Process other({"emulate", examples + "grasp.txtpb"});
    EXPECT_EQ(other.wait(), 1);
    EXPECT_NE(other.err().find("no hand.ability_hand"), std::string::npos) << other.err();
}

}  // namespace
}  // namespace afferent
