// afferent run --set, --duration, and afferent sweep.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/apps/process.hpp"

namespace afferent {
namespace {

const std::string swept_scene = examples + "grasp.txtpb";

nlohmann::json json_of(const std::vector<std::string>& arguments) {
    Process process(arguments);
    EXPECT_EQ(process.wait(), 0) << process.err();
    return nlohmann::json::parse(process.out(), nullptr, false);
}

TEST(SettingOptions, ReplaceFieldsOfTheScene) {
    const auto plain = json_of({"run", swept_scene, "--duration", "2", "--json"});
    const auto set = json_of(
        {"run", "--set", "neuron.delta_g=0", "--set", "seed=9", swept_scene, "--duration", "2", "--json"});
    EXPECT_EQ(plain.at("duration_s"), 2);
    EXPECT_EQ(set.at("seed"), 9);
    EXPECT_GT(set.at("events").get<int>(), plain.at("events").get<int>());  // what does not adapt fires on
}

TEST(SettingOptions, AreNamedWhereTheyAreWrong) {
    Process process({"run", swept_scene, "--set", "neuron.delta_gg=0"});
    EXPECT_EQ(process.wait(), 1);
    EXPECT_NE(process.err().find("neuron.delta_gg=0: Neuron has no field \"delta_gg\": did you mean"),
              std::string::npos)
        << process.err();
}

TEST(SweepCommand, WritesATableAndAPicture) {
    const Folder folder;
    const auto swept = json_of({"sweep", swept_scene, "--duration", "2", "--set", "link=udp", "--over",
                                "decoder=interval,filter", "--over", "link.packet_ms=1,20", "--json", "--out",
                                folder / "out"});
    ASSERT_EQ(swept.at("points").size(), 4u);
    EXPECT_EQ(swept.at("points").at(1).at("decoder"), "interval");
    EXPECT_EQ(swept.at("points").at(1).at("link.packet_ms"), "20");
    EXPECT_GT(swept.at("points").at(0).at("link_bytes").get<int>(),
              swept.at("points").at(1).at("link_bytes").get<int>());
    const std::string table = read_file(folder / "out/sweep.csv");
    EXPECT_TRUE(table.starts_with("decoder,link.packet_ms,events,packets,link_bytes,")) << table;
    EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 5);
    EXPECT_EQ(nlohmann::json::parse(read_file(folder / "out/sweep.json"))["points"], swept.at("points"));
    if (std::system("gnuplot --version >/dev/null 2>&1") == 0) {
        EXPECT_TRUE(std::filesystem::exists(folder / "out/sweep.png"));
    }
}

TEST(SweepCommand, SaysWhatItIsNotGiven) {
    Process process({"sweep", swept_scene});
    EXPECT_EQ(process.wait(), 1);
    EXPECT_NE(process.err().find("--over PATH=VALUE,VALUE is missing"), std::string::npos) << process.err();
}

}  // namespace
}  // namespace afferent
