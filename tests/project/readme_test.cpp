// The README is true.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <utility>

#include "tests/project/file_content.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

const fs::path project = AFFERENT_SOURCE_DIR;

class Readme : public ::testing::Test {
  protected:
    const std::string text_ = content(project / "README.md");
};

TEST_F(Readme, ShowsProgramsThatAreCompiledAndRun) {
    const std::pair<const char*, int> programs[] = {{"embed.cpp", 15}, {"embed_controller.cpp", 30}};
    for (const auto& [name, most_lines] : programs) {
        const std::string program = content(project / "examples" / name);
        EXPECT_NE(text_.find("```cpp\n" + program + "```\n"), std::string::npos)
            << "README.md does not show examples/" << name << " as it is";
        EXPECT_LE(std::count(program.begin(), program.end(), '\n'), most_lines) << name;
    }
}

TEST_F(Readme, NamesCommandsThatAreThere) {
    for (const char* const command : {"demo.sh", "test.sh"}) {
        EXPECT_NE(text_.find("./" + std::string(command)), std::string::npos) << command;
        const auto permissions = fs::status(project / command).permissions();
        EXPECT_NE(permissions & fs::perms::owner_exec, fs::perms::none) << command;
    }
}

}  // namespace
}  // namespace afferent
