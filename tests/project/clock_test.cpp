// No session depends on a clock that can be set, by a date, an operator or a time server.
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>

#include "tests/project/file_content.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

TEST(Clocks, ThatCanBeSetAreReadForFilesAlone) {
    // They write the date into files of other programs' formats.
    const std::set<std::string> may{"apps/event_file.cpp",       "apps/hdf5_main.cpp",
                                    "io/files/hdf5_process.cpp", "io/files/hdf5_process.hpp",
                                    "io/files/nwb_file.cpp",     "io/files/nwb_file.hpp"};
    const std::regex settable(
        R"(system_clock|utc_clock|gettimeofday|CLOCK_REALTIME|\btime\(nullptr\)|\btime\(NULL\))");
    std::size_t files = 0;
    for (const char* folder :
         {"runtime", "neurons", "encoders", "decoders", "io", "hand", "scene", "engine", "apps"}) {
        const fs::path root = fs::path(AFFERENT_SOURCE_DIR) / folder;
        for (const auto& entry : fs::recursive_directory_iterator(root)) {
            if (entry.path().extension() != ".cpp" && entry.path().extension() != ".hpp") continue;
            ++files;
            const auto name = fs::relative(entry.path(), AFFERENT_SOURCE_DIR).string();
            EXPECT_TRUE(may.contains(name) || !std::regex_search(content(entry.path()), settable)) << name;
        }
    }
    EXPECT_GT(files, 100U);
}

}  // namespace
}  // namespace afferent
