// How long a scene lasts that does not say so.
#include "afferent/scene/scene_table.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

class SceneWithATable : public testing::Test {
  protected:
    SceneWithATable() {
        std::filesystem::create_directories(folder_);
        std::ofstream(folder_ / "f.csv") << "t_ms;f_n\n1000000;1\n1000500;2\n1001000;3\n";
    }
    ~SceneWithATable() override { std::filesystem::remove_all(folder_); }
    double duration_s(const std::string& text) const {
        return make_plan(Scene::from_text(text, "scene", folder_)).scene.duration_s.value();
    }
    std::filesystem::path folder_ = std::filesystem::path(testing::TempDir()) /
                                    ("afferent-scene-table-" + std::to_string(std::random_device()()));
};

TEST_F(SceneWithATable, LastsAsLongAsTheTable) {
    EXPECT_EQ(duration_s("source { table { path: 'f.csv' } }"), 1.5)
        << "the last row lasts as long as the others";
    EXPECT_EQ(duration_s("source { link { table { path: 'f.csv' } } }"), 1.5);
    EXPECT_EQ(duration_s("source { table { path: 'f.csv' begin_s: 1000.25 } }"), 1.25);
    EXPECT_EQ(duration_s("source { table { path: 'f.csv' rate_hz: 100 column: 'f_n' } }"), 0.03);
    EXPECT_EQ(duration_s("duration_s: 4 source { table { path: 'f.csv' } }"), 4);
    EXPECT_EQ(duration_s("source { table { path: 'none.csv' } }"), 10) << "it is refused when it is opened";
    EXPECT_EQ(duration_s(""), 10);
    EXPECT_EQ(Scene().end(), scene_start + 10s);
}

TEST_F(SceneWithATable, IsTheSameSceneWhetherItsDefaultIsWrittenOrNot) {
    Scene scene;
    const std::uint64_t fingerprint = scene.fingerprint();
    scene.duration_s = 10;
    EXPECT_EQ(scene.fingerprint(), fingerprint);
    scene.duration_s = 11;
    EXPECT_NE(scene.fingerprint(), fingerprint);
}

TEST_F(SceneWithATable, TakesARateOrAColumnOfTime) {
    try {
        Scene::from_text("source { table { path: 'f.csv' rate_hz: 100 time_column: 't' } }");
        FAIL() << "accepted";
    } catch (const SceneError& error) {
        EXPECT_NE(
            std::string(error.what()).find("table.rate_hz must be absent where time_column is given, is 100"),
            std::string::npos)
            << error.what();
    }
}

}  // namespace
}  // namespace afferent
