// afferent trial: the tables, pictures and errors of the command.
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/apps/process.hpp"

namespace afferent {
namespace {

using TrialJson = nlohmann::json;

const std::string trial_scene = examples + "trial.txtpb";

class TrialCommand : public testing::Test {
  protected:
    TrialJson report(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), {"trial", trial_scene, "--json"});
        Process process(std::move(arguments));
        EXPECT_EQ(process.wait(), 0) << process.err();
        return TrialJson::parse(process.out(), nullptr, false);
    }
    static std::string refusal(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), "trial");
        Process process(std::move(arguments));
        EXPECT_EQ(process.wait(), 1);
        return process.err();
    }
    std::string text(const std::string& file) const { return read_file(folder_ / file); }
    bool is_there(const std::string& file) const { return std::filesystem::exists(folder_ / file); }
    static bool has_gnuplot() { return std::system("gnuplot --version >/dev/null 2>&1") == 0; }

    const Folder folder_;
};

std::vector<std::string> lines_of_table(const std::string& table) {
    std::istringstream in(table);
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

TEST_F(TrialCommand, WritesATableOfPresentationsOneOfConditionsAndTheirPictures) {
    const TrialJson told =
        report({"--presentations", "40", "--conditions", "none,rate", "--out", folder_("out")});
    const auto rows = lines_of_table(text("out/trial.csv"));
    ASSERT_EQ(rows.size(), 1U + 2 * 40);
    EXPECT_TRUE(rows[0].starts_with("condition,number,object,outcome,breaking_force_n,"));
    EXPECT_TRUE(rows[1].starts_with("none,0,"));
    EXPECT_TRUE(rows[41].starts_with("rate,0,"));
    const auto summary = lines_of_table(text("out/trial_summary.csv"));
    ASSERT_EQ(summary.size(), 3U);
    EXPECT_EQ(summary[0],
              "condition,presentations,broken_pct,broken_low_pct,broken_high_pct,dropped_pct,paper_pct,"
              "fitted_or_predicted,told_p50_s,answer_p10_s,answer_p50_s,answer_p90_s");
    EXPECT_TRUE(summary[1].starts_with("none,") && summary[1].ends_with(",27.5,fitted,,,,")) << summary[1];
    EXPECT_TRUE(summary[2].starts_with("rate,")) << summary[2];
    EXPECT_NE(summary[2].find(",14.5,predicted,0."), std::string::npos) << summary[2];

    // Whose EMG was recorded is not the user who was calibrated.
    std::string scene = read_file(trial_scene);
    const std::string hand = "\nhand {";
    scene.replace(scene.find(hand), hand.size(),
                  hand + " emg_table { path: '" + examples + "data/emg.csv' }");
    write_file(folder_("recorded.txtpb"), scene);
    Process recorded({"trial", folder_("recorded.txtpb"), "--presentations", "5", "--conditions", "none"});
    EXPECT_EQ(recorded.wait(), 0) << recorded.err();
    EXPECT_EQ(recorded.out().find("27.5"), std::string::npos) << recorded.out();

    // The table of conditions is that of the presentations, counted here.
    int broken = 0;
    int delicate = 0;
    for (const std::string& row : rows) {
        delicate += row.starts_with("rate,") && row.find(",delicate,") != std::string::npos;
        broken += row.starts_with("rate,") && row.find(",delicate,broken,") != std::string::npos;
    }
    const TrialJson& rate = told.at("conditions").at(1);
    EXPECT_EQ(rate.at("condition"), "rate");
    EXPECT_EQ(rate.at("presentations"), delicate);
    EXPECT_NEAR(rate.at("broken_pct").get<double>(), 100.0 * broken / delicate, 1e-9);
    EXPECT_LE(rate.at("broken_low_pct").get<double>(), rate.at("broken_pct").get<double>());
    EXPECT_GE(rate.at("broken_high_pct").get<double>(), rate.at("broken_pct").get<double>());
    EXPECT_EQ(rate.at("slippery").at("presentations"), 40 - delicate);
    EXPECT_FALSE(told.at("interrupted"));
    EXPECT_TRUE(is_there("out/summary.json"));
    EXPECT_TRUE(is_there("out/trial_slip.csv"));
    if (has_gnuplot()) {
        for (const char* picture : {"trial.svg", "trial.png", "trial_grasps.svg", "trial_grasps.png"})
            EXPECT_GT(std::filesystem::file_size(folder_ / ("out/" + std::string(picture))), 5'000U)
                << picture;
        // One word for a condition, in tables and pictures.
        EXPECT_NE(text("out/trial.svg").find(">rate<"), std::string::npos);
        EXPECT_NE(text("out/trial_grasps.svg").find(">rate: "), std::string::npos);
    }
}

TEST_F(TrialCommand, GivesTheSameForAnyNumberOfThreadsAndOtherwiseForAnotherSeed) {
    const std::vector<std::string> few{"--presentations", "30", "--conditions", "rate,send_on_delta"};
    const auto in = [&](const std::string& out, const std::vector<std::string>& more) {
        std::vector<std::string> arguments = few;
        arguments.insert(arguments.end(), {"--out", folder_(out)});
        arguments.insert(arguments.end(), more.begin(), more.end());
        report(arguments);
        return text(out + "/trial.csv");
    };
    const std::string one = in("one", {"--threads", "1"});
    EXPECT_EQ(lines_of_table(one).size(), 1U + 2 * 30);
    EXPECT_EQ(one, in("three", {"--threads", "3"}));
    EXPECT_NE(one, in("other", {"--seed", "7"}));
}

TEST_F(TrialCommand, SaysWhatIsFittedWhatIsPredictedAndHowTheDecodersCompare) {
    Process process({"trial", trial_scene, "--presentations", "60", "--conditions",
                     "none,force,rate,filter,send_on_delta"});
    EXPECT_EQ(process.wait(), 0) << process.err();
    for (const char* said : {"27.5", "fitted", "Predicted: how many more break with rate than with force",
                             "Osborn et al. (2016) have less than 0.5", "The published 35 to 85 ms",
                             "Against rate", "Nothing is written"})
        EXPECT_NE(process.out().find(said), std::string::npos) << said << "\n" << process.out();
}

TEST_F(TrialCommand, MeasuresSensitivityFaultsAndAblations) {
    // One that is drawn, at five values, and one that is not, at both ends of its range.
    const TrialJson moved =
        report({"--sensitivity", "--presentations", "10", "--conditions", "none", "--numbers",
                "trial.user.reaction_ms,trial.user.aim_n", "--out", folder_("sensitivity")});
    ASSERT_EQ(moved.at("sensitivity").size(), 1U + 5 + 2);
    EXPECT_EQ(moved.at("sensitivity").at(0).at("changed"), "") << "the scene as it is";
    EXPECT_EQ(lines_of_table(text("sensitivity/sensitivity.csv")).size(), 1U + 8);
    ASSERT_EQ(moved.at("numbers").size(), 2U);
    EXPECT_LT(moved.at("sensitivity").at(6).at("broken_pct").get<double>(),
              moved.at("sensitivity").at(7).at("broken_pct").get<double>())
        << "users who aim at 4 N break less than those who aim at 14 N";
    const TrialJson faults =
        report({"--faults", "--presentations", "10", "--conditions", "rate", "--out", folder_("faults")});
    const TrialJson& dead = faults.at("faults").at(6);
    EXPECT_EQ(dead.at("value"), 1);
    EXPECT_EQ(dead.at("safe_state_pct"), 100) << "a link that loses all packets";
    EXPECT_EQ(dead.at("broken_pct"), 0) << "a hand in its safe state closes on nothing";
    EXPECT_EQ(faults.at("faults").at(0).at("safe_state_pct"), 0);
    const TrialJson ablated = report(
        {"--ablations", "--presentations", "10", "--conditions", "filter", "--out", folder_("ablations")});
    ASSERT_EQ(ablated.at("ablations").size(), 4U);
    EXPECT_EQ(ablated.at("ablations").at(1).at("changed"), "no_adaptation");
    if (has_gnuplot()) {
        for (const char* picture :
             {"sensitivity/sensitivity.png", "faults/faults.png", "ablations/ablations.png"})
            EXPECT_GT(std::filesystem::file_size(folder_ / picture), 5'000U) << picture;
    }
}

TEST_F(TrialCommand, CalibratesASceneThatItWrites) {
    Process process({"trial", trial_scene, "--calibrate", "--presentations", "40", "--out", folder_("c")});
    EXPECT_EQ(process.wait(), 0) << process.err();
    EXPECT_NE(process.out().find("trial.user.aim_n"), std::string::npos);
    // It is a trial itself.
    Process again({"trial", folder_("c/scene.txtpb"), "--presentations", "1", "--conditions", "none"});
    EXPECT_EQ(again.wait(), 0) << again.err();
}

TEST_F(TrialCommand, KeepsWhatItHasFoundWhenItIsInterrupted) {
    // More than could be presented before the signal.
    Process process({"trial", trial_scene, "--presentations", "4000000", "--out", folder_("out")});
    ASSERT_TRUE(comes_true([&] { return has_begun_in(folder_ / "out"); }));
    std::this_thread::sleep_for(std::chrono::milliseconds(300));  // of presentations
    process.signal(SIGINT);
    EXPECT_EQ(process.wait(), 130) << process.err();
    const auto told = TrialJson::parse(text("out/summary.json"), nullptr, false);
    EXPECT_TRUE(told.at("interrupted"));
    ASSERT_TRUE(is_there("out/trial.csv"));
    EXPECT_LT(lines_of_table(text("out/trial.csv")).size(), 4'000'000U);
}

TEST_F(TrialCommand, RefusesWhatItCannotPresent) {
    EXPECT_NE(refusal({examples + "grasp.txtpb"}).find("has no trial"), std::string::npos);
    EXPECT_NE(refusal({trial_scene, "--conditions", "none,rat"}).find("rate"), std::string::npos);
    EXPECT_NE(refusal({trial_scene, "--conditions", "rate,rate"}).find("twice"), std::string::npos);
    EXPECT_NE(
        refusal({trial_scene, "--sensitivity", "--numbers", "trial.user.reaction"}).find("did you mean"),
        std::string::npos);
    EXPECT_NE(refusal({trial_scene, "--numbers", "trial.user.reaction_ms"}).find("--sensitivity"),
              std::string::npos);
    EXPECT_NE(refusal({trial_scene, "--faults", "--ablations"}).find("one of them"), std::string::npos);
    EXPECT_NE(refusal({trial_scene, "--calibrate", "--conditions", "none"}).find("--conditions"),
              std::string::npos);
}

TEST_F(TrialCommand, FindsTheGainOfEachConditionAndWritesItIntoTheScene) {
    Process process({"tune", "--gain", trial_scene, "--conditions", "rate,force", "--presentations", "16",
                     "--dropped", "30", "--out", folder_("gain"), "--json"});
    ASSERT_EQ(process.wait(), 0) << process.err();
    const TrialJson told = TrialJson::parse(process.out(), nullptr, false);
    ASSERT_EQ(told.at("fronts").size(), 2U);
    EXPECT_EQ(told.at("held_out_seed"), told.at("seed").get<int>() + 1);
    EXPECT_EQ(told.at("compared").at(0).at("condition"), "force");
    EXPECT_EQ(told.at("compared").at(0).at("against"), "rate");
    EXPECT_TRUE(lines_of_table(text("gain/gain.csv")).at(1).starts_with("rate,"));
    EXPECT_EQ(has_gnuplot(),
              is_there("gain/gain.svg") && text("gain/gain.svg").find(">rate<") != std::string::npos);
    EXPECT_TRUE(is_there("gain/gain.json"));
    // What it wrote is a scene, whose gains the trial takes.
    Process trial({"trial", folder_("gain/scene.txtpb"), "--conditions", "rate", "--presentations", "4"});
    EXPECT_EQ(trial.wait(), 0) << trial.err();
    EXPECT_NE(text("gain/scene.txtpb").find("name: \"force\""), std::string::npos)
        << text("gain/scene.txtpb");
}

TEST_F(TrialCommand, WritesAScenesTablesAsItsFolderSeesThem) {
    std::string scene = read_file(trial_scene);
    const std::string hand = "\nhand {";
    scene.replace(scene.find(hand), hand.size(), hand + " emg_table { path: 'emg.csv' }");
    write_file(folder_("recorded.txtpb"), scene);
    std::filesystem::copy_file(examples + "data/emg.csv", folder_ / "emg.csv");
    Process process({"tune", "--gain", folder_("recorded.txtpb"), "--conditions", "force", "--presentations",
                     "2", "--out", folder_("gain")});
    ASSERT_EQ(process.wait(), 0) << process.err();
    Process trial({"trial", folder_("gain/scene.txtpb"), "--conditions", "force", "--presentations", "1"});
    EXPECT_EQ(trial.wait(), 0) << trial.err();
}

TEST_F(TrialCommand, RefusesAGainThatCannotBeFound) {
    const auto refused = [](std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), {"tune", "--gain"});
        Process process(std::move(arguments));
        EXPECT_NE(process.wait(), 0);
        return process.err();
    };
    EXPECT_NE(refused({trial_scene, "--conditions", "none"}).find("none has no feedback"), std::string::npos);
    EXPECT_NE(refused({trial_scene, "--conditions", "rat"}).find("did you mean \"rate\"?"),
              std::string::npos);
    EXPECT_NE(refused({trial_scene, "--held-out-seed", "1"}).find("--held-out-seed: must not be"),
              std::string::npos);
    EXPECT_NE(refused({examples + "grasp.txtpb"}).find("has no trial"), std::string::npos);
    EXPECT_NE(refused({trial_scene, "--dropped", "101"}).find("--dropped"), std::string::npos);
    EXPECT_NE(refused({trial_scene, "--conditions", ""}).find("--conditions"), std::string::npos);
    Process neurons({"tune", examples + "grasp.txtpb", "--dropped", "1"});
    EXPECT_NE(neurons.wait(), 0);
    EXPECT_NE(neurons.err().find("--gain"), std::string::npos) << neurons.err();
}

}  // namespace
}  // namespace afferent
