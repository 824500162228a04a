// The outputs of a scene, all together.
#include "afferent/nodes/outputs.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

TEST(Outputs, CloseWithTheFirstErrorOfAll) {
    if (!fs::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
    const fs::path folder = fs::temp_directory_path() / ("afferent-" + std::to_string(getpid()) + ".outputs");
    fs::create_directory(folder);
    Scene scene;
    for (const char* name : {"whole.csv", "first.csv", "second.csv"})
        scene.output.emplace_back(scene::CommandFile{(folder / name).string()});
    fs::create_symlink("/dev/full", folder / "first.csv");
    fs::create_symlink("/dev/full", folder / "second.csv");
    Outputs outputs = value_or_throw(Outputs::open(scene));
    outputs.take({});
    const Result<void> closed = outputs.close();
    fs::remove_all(folder);
    ASSERT_FALSE(closed);
    EXPECT_NE(closed.error().text.find("first.csv"), std::string::npos) << closed.error().text;
}

}  // namespace
}  // namespace afferent
