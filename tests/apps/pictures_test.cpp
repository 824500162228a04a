// What is drawn of a population, from a scene and from what is left of a run.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/apps/process.hpp"

namespace afferent {
namespace {

class PopulationFiles : public testing::Test {
  protected:
    // Runs the program, and returns what it says.
    static nlohmann::json report(std::vector<std::string> arguments) {
        arguments.emplace_back("--json");
        Process process(std::move(arguments));
        EXPECT_EQ(process.wait(), 0) << process.err();
        return nlohmann::json::parse(process.out(), nullptr, false);
    }
    static std::string refusal(const std::vector<std::string>& arguments) {
        Process process(arguments);
        EXPECT_EQ(process.wait(), 1);
        return process.err();
    }

    // A small skin, and a link, so that it can be recorded.
    std::string skin() const {
        return write_file(folder_ / "skin.txtpb",
                          "name: 'skin' duration_s: 0.3 record { force: false } link { tcp { port: 0 } } "
                          "patch { name: 'skin' kind: SA1 outline { ellipse { width_mm: 6 height_mm: 4 } "
                          "pitch_mm: 0.5 } "
                          "        sensor { rate_hz: 1000 full_scale_n: 0.02 adc_bits: 20 } } "
                          "patch { name: 'deep' kind: PC elements_of: 'skin' } "
                          "source { edge { speed_mm_per_s: 20 begin_mm: -4 } }")
            .string();
    }

    const Folder folder_;
};

TEST_F(PopulationFiles, HaveAPictureOfWhatIsReadOut) {
    report({"run", skin(), "--set", "decoder={ filter {} contact {} }", "--out", folder_("out")});
    if (std::system("gnuplot --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "no gnuplot";
    EXPECT_GT(std::filesystem::file_size(folder_ / "out/readouts.png"), 10'000U);
    const std::string picture = read_file(folder_ / "out/readouts.svg");
    for (const char* const told : {"force_n", "x_mm", "y_mm", "area_mm2", "skin"})
        EXPECT_NE(picture.find(told), std::string::npos) << told;
    EXPECT_EQ(picture.find("roughness_hz"), std::string::npos) << "no texture is asked for";
    // A run without read-outs removes the picture of the run before.
    report({"run", skin(), "--out", folder_("out")});
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out/readouts.svg"));
}

TEST_F(PopulationFiles, AreAPictureAndATableBesideTheEvents) {
    const auto run = report({"run", skin(), "--out", folder_("out"), "--record", folder_("r.afferent")});
    EXPECT_GT(run.at("events"), 20);
    const std::string table = read_file(folder_ / "out/afferents.csv");
    EXPECT_TRUE(
        table.starts_with("address,patch,kind,x_mm,y_mm,element,elements,resolution_ns\n0,skin,SA1,"));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out/grasp.png")) << "nobody grasps anything";
    if (std::system("gnuplot --version >/dev/null 2>&1") == 0) {
        EXPECT_GT(std::filesystem::file_size(folder_ / "out/population.png"), 10'000U);
        EXPECT_GT(std::filesystem::file_size(folder_ / "out/population.svg"), 10'000U);
    }
    // The events are those of the afferents in the table, silent ones included, to the nanosecond.
    const auto converted = report({"convert", folder_("out/events.csv"), folder_("a.nwb")});
    EXPECT_EQ(converted.at("patches").at(1).at("kind"), "PC");
    const auto rows = static_cast<std::size_t>(std::count(table.begin(), table.end(), '\n')) - 1;
    EXPECT_EQ(converted.at("patches").at(0).at("afferents").get<std::size_t>() +
                  converted.at("patches").at(1).at("afferents").get<std::size_t>(),
              rows);
    EXPECT_EQ(converted.at("resolution_us"), 0.001);
    EXPECT_EQ(report({"convert", folder_("r.afferent"), folder_("r.csv")})["resolution_us"], 100);
    EXPECT_EQ(report({"convert", folder_("r.csv"), folder_("b.nwb")})["resolution_us"], 100)
        << "by its table";
    // A table of other afferents is refused.
    write_file(folder_ / "out/afferents.csv",
               "address,patch,kind,x_mm,y_mm,element,elements,resolution_ns\n0,a,SA1,0,0,0,1,1\n");
    EXPECT_NE(refusal({"convert", folder_("out/events.csv"), folder_("c.nwb")}).find("does not belong to"),
              std::string::npos);
}

TEST_F(PopulationFiles, GiveTheSameMovieFromASceneARecordingAndAFolder) {
    const std::string scene = skin();
    const auto run = report({"run", scene, "--out", folder_("out"), "--record", folder_("r.afferent")});
    const auto of_scene = report({"movie", scene, "--out", folder_("s.html")});
    EXPECT_EQ(of_scene.at("events"), run.at("events"));
    EXPECT_EQ(of_scene.at("bytes"), std::filesystem::file_size(folder_ / "s.html"));
    EXPECT_TRUE(of_scene.at("pressure"));
    const auto of_recording = report({"movie", folder_("r.afferent"), "--out", folder_("r.html")});
    EXPECT_EQ(of_recording.at("events"), run.at("events"));
    EXPECT_TRUE(of_recording.at("pressure")) << "the edge follows from the scene that it holds";
    const auto of_folder = report({"movie", folder_("out"), "--out", folder_("f.html")});
    EXPECT_EQ(of_folder.at("events"), run.at("events"));
    EXPECT_FALSE(of_folder.at("pressure")) << "nothing in it tells of the edge";
    const auto part =
        report({"movie", scene, "--out", folder_("p.html"), "--from-s", "0.1", "--to-s", "0.15"});
    EXPECT_GT(part.at("events").get<int>(), 0);
    EXPECT_LT(part.at("events").get<int>(), run.at("events").get<int>());
    EXPECT_EQ(part.at("to_s"), 0.15);
}

TEST_F(PopulationFiles, AreRefusedWithWhatToDo) {
    const std::string scene = skin();
    const auto expect = [](const std::string& said, const std::string& text) {
        EXPECT_NE(said.find(text), std::string::npos) << said;
    };
    expect(
        refusal({"movie", examples + "grasp.txtpb", "--out", folder_("g.html")}),
        "no afferent has a place, so there is nothing to see from above. A patch has places where the scene "
        "gives it an outline");
    expect(refusal({"movie", scene, "--out", folder_("s.html"), "--largest-mb", "0.025"}),
           "the movie takes more than 0.025 MB. Give less of it with --from-s and --to-s, or allow more with "
           "--largest-mb");
    EXPECT_FALSE(std::filesystem::exists(folder_ / "s.html"));
    expect(refusal({"movie", scene, "--out", folder_("s.html"), "--from-s", "7"}),
           "--from-s: the end is at 0.3 s, and nothing is later");
    expect(refusal({"movie", scene, "--out", folder_("s.html"), "--from-s", "0.2", "--to-s", "0.1"}),
           "--to-s: must be later than --from-s");
    expect(refusal({"movie", scene, "--out", folder_("none/s.html")}), "none/s.html: cannot be written");
    expect(refusal({"movie", folder_(""), "--out", folder_("s.html")}), "events.csv: cannot be read");
}

}  // namespace
}  // namespace afferent
