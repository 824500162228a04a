#include "tests/project/dependency_rule.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/project/file_content.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

bool is_code(const fs::path& file) {
    return file.extension() == ".hpp" || file.extension() == ".cpp" || file.extension() == ".h" ||
           file.extension() == ".c";
}

TEST(DependencyRule, HoldsInEveryFile) {
    std::size_t files = 0;
    for (const auto& [folder, ignored] : may_include) {
        const fs::path root = fs::path(AFFERENT_SOURCE_DIR) / folder;
        ASSERT_TRUE(fs::exists(root)) << folder;
        for (const auto& entry : fs::recursive_directory_iterator(root)) {
            if (!is_code(entry.path())) continue;
            ++files;
            const auto name = fs::relative(entry.path(), AFFERENT_SOURCE_DIR).string();
            for (const std::string& text : violations(name, content(entry.path()))) ADD_FAILURE() << text;
        }
    }
    EXPECT_GT(files, 50U);
}

// Every folder with code is in the table, or is known to be outside the library.
TEST(DependencyRule, CoversEveryFolder) {
    const Names outside{"tests", "examples", "build", "out"};
    for (const auto& entry : fs::directory_iterator(AFFERENT_SOURCE_DIR)) {
        const std::string folder = entry.path().filename();
        if (!entry.is_directory() || folder.starts_with('.') || outside.contains(folder)) continue;
        const auto files = fs::recursive_directory_iterator(entry.path());
        const bool has_code =
            std::any_of(begin(files), end(files), [](const auto& f) { return is_code(f.path()); });
        EXPECT_TRUE(!has_code || may_include.contains(folder) || folder == "io") << folder;
    }
}

TEST(DependencyRule, GoesOneWay) {
    EXPECT_TRUE(
        violations("neurons/a.hpp", "#include \"afferent/runtime/event.hpp\"\n#include <vector>\n").empty());
    EXPECT_EQ(violations("runtime/a.hpp", "#include <afferent/neurons/lif.hpp>").size(), 1U);
    EXPECT_EQ(violations("decoders/a.hpp", "#include <afferent/io/files/table.hpp>").size(), 1U);
    EXPECT_TRUE(violations("engine/a.cpp", "#include \"afferent/scene/plan.hpp\"").empty());
    EXPECT_EQ(violations("scene/a.cpp", "#include \"afferent/engine/make_shard.hpp\"").size(), 1U)
        << "a plan is computed, and builds nothing";
    EXPECT_EQ(violations("hand/a.hpp", "#  include \"afferent/neurons/lif.hpp\"").size(), 1U);
}

TEST(DependencyRule, KeepsLibrariesWhereTheyBelong) {
    EXPECT_TRUE(violations("runtime/parallel.cpp", "#include <oneapi/tbb/parallel_for.h>").empty());
    EXPECT_EQ(violations("runtime/shard.cpp", "#include <oneapi/tbb/parallel_for.h>").size(), 1U);
    EXPECT_EQ(violations("decoders/a.cpp", "#include <boost/asio/ip/tcp.hpp>").size(), 1U);
    EXPECT_EQ(violations("decoders/a.cpp", "#include <google/protobuf/message.h>").size(), 1U);
    EXPECT_EQ(violations("runtime/a.cpp", "#include <unknown/library.hpp>").size(), 1U);
    EXPECT_EQ(violations("runtime/a.cpp", "#include \"event.hpp\"").size(), 1U);
}

TEST(DependencyRule, LetsNoLibraryPrintOrExit) {
    EXPECT_EQ(
        violations("io/wire/a.cpp", "#include <iostream>\nstd::cout << 1; printf (\"a\"); exit(1);").size(),
        4U);
    EXPECT_TRUE(violations("apps/a.cpp", "#include <iostream>\nstd::cout << 1; exit(1);").empty());
    EXPECT_TRUE(violations("io/wire/a.cpp",
                           "// std::cout, exit(1)\nsnprintf(b, 1'000, \"exit(1)\"); '\"'; /* abort() */")
                    .empty());
}

}  // namespace
}  // namespace afferent
