#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/apps/process.hpp"

namespace afferent {
namespace {

using Json = nlohmann::json;

const std::string examples = AFFERENT_SOURCE_DIR "/examples/";

// A run's own spikes, and the force that it was given, lead back to its scene; and what is written can be
// run.
TEST(Calibrate, WritesASceneThatIsThatOfTheRun) {
    const Folder folder;
    Process run({"run", examples + "recorded.txtpb", "--record", folder("r.afferent")});
    ASSERT_EQ(run.wait(), 0) << run.err();
    Process calibrate({"calibrate", examples + "recorded.txtpb", "--from", examples + "data/grip.csv",
                       "--events", folder("r.afferent"), "--out", folder("fitted"), "--json"});
    ASSERT_EQ(calibrate.wait(), 0) << calibrate.err();
    const Json fit = Json::parse(calibrate.out());
    const double shares[] = {0.20, 0.18, 0.12, 0.11, 0.10, 0.06, 0.10, 0.08, 0.05};
    ASSERT_EQ(fit.at("shares").size(), 9U);
    for (std::size_t i = 0; i < 9; ++i)
        EXPECT_NEAR(fit.at("shares").at(i).at("share").get<double>(), shares[i], 0.002);
    EXPECT_EQ(fit.at("patches").size(), 3U);
    for (const Json& patch : fit.at("patches")) {
        EXPECT_GT(patch.at("intervals"), 100);
        EXPECT_LT(patch.at("residual_n").get<double>(), 0.02);
    }
    EXPECT_FALSE(fit.contains("uncertainty")) << "the grip alone is in the table";
    EXPECT_GT(fit.at("motions").at("log_density").get<double>(),
              fit.at("motions").at("log_density_before").get<double>());
    EXPECT_EQ(fit.at("motions").at("written"), false) << "the scene's decoder is no filter";
    EXPECT_TRUE(std::filesystem::exists(folder / "fitted/drive.svg"));
    EXPECT_TRUE(std::filesystem::exists(folder / "fitted/motion.svg"));
    EXPECT_TRUE(std::filesystem::exists(folder / "fitted/summary.json"));
    Process again({"run", folder("fitted/scene.txtpb"), "--json"});
    ASSERT_EQ(again.wait(), 0) << again.err();
    EXPECT_LT(Json::parse(again.out()).at("force_error_rms_n").get<double>(), 1);
}

TEST(Calibrate, TellsPeopleWhatItFoundAndWritesNothingUnasked) {
    Process calibrate({"calibrate", examples + "grasp.txtpb", "--from", examples + "data/grip.csv"});
    ASSERT_EQ(calibrate.wait(), 0) << calibrate.err();
    EXPECT_NE(calibrate.out().find("How the force moves"), std::string::npos);
    EXPECT_NE(calibrate.out().find("Nothing is written"), std::string::npos);
    Process wrong({"calibrate", examples + "grasp.txtpb", "--from", examples + "data/emg.csv"});
    EXPECT_GT(wrong.wait(), 0);
    EXPECT_NE(wrong.err().find("one column of grip force"), std::string::npos) << wrong.err();
}

}  // namespace
}  // namespace afferent
