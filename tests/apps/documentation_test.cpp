// What README and docs/ tell a user to type exists, and runs where it needs nothing but the repository.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "afferent/scene/scene.hpp"
#include "tests/apps/process.hpp"

namespace afferent {
namespace {

const std::filesystem::path repository = AFFERENT_SOURCE_DIR;

std::vector<std::filesystem::path> documented_pages() {
    std::vector<std::filesystem::path> all{repository / "README.md"};
    for (const auto& entry : std::filesystem::directory_iterator(repository / "docs"))
        if (entry.path().extension() == ".md") all.push_back(entry.path());
    return all;
}

// What is typed: lines of code that begin with the program, and code within a line of text. Without comments.
std::vector<std::string> typed_commands(const std::string& page) {
    static const std::regex typed(
        "(?:^|\\n)    (?:[^\\n|]*[|&] |mpirun [^\\n]*? )?(afferent [^#\\n|>]*)|`(afferent [^`]*)`");
    std::vector<std::string> all;
    for (std::sregex_iterator it(page.begin(), page.end(), typed), end; it != end; ++it)
        all.push_back((*it)[1].matched ? (*it)[1] : (*it)[2]);
    return all;
}

// The help of a command, asked for once. Empty where there is no such command.
const std::string& help_of(const std::string& command) {
    static std::map<std::string, std::string> known;
    const auto [place, is_new] = known.try_emplace(command);
    if (!is_new) return place->second;
    std::vector<std::string> arguments;
    std::istringstream words(command);
    for (std::string word; words >> word;) arguments.push_back(word);
    arguments.push_back("--help");
    Process process(arguments);
    if (process.wait() == 0) place->second = process.out();
    return place->second;
}

TEST(Documentation, NamesCommandsAndOptionsThatExist) {
    static const std::regex words("afferent(?: (bench [a-z]+|link status|[a-z]+))?");
    static const std::regex option("(^| )(--[a-z-]+)");
    std::set<std::string> checked;
    for (const auto& page : documented_pages()) {
        for (const std::string& line : typed_commands(read_file(page))) {
            std::smatch match;
            if (!std::regex_search(line, match, words, std::regex_constants::match_continuous)) continue;
            const std::string command = match[1];
            const std::string& help = help_of(command);
            // A program of its own, which need not be built.
            if (command.starts_with("bench") && help.empty()) continue;
            ASSERT_FALSE(help.empty()) << page << " names afferent " << command;
            checked.insert(command);
            for (std::sregex_iterator it(line.begin(), line.end(), option), end; it != end; ++it)
                EXPECT_TRUE(std::regex_search(help, std::regex("[ ,]" + (*it)[2].str() + "[ \\n]")))
                    << page << ": " << line << ": there is no " << (*it)[2];
        }
    }
    EXPECT_GT(checked.size(), 10U);
}

// What a page shows: tables, and scenes whose first line names them.
std::vector<std::string> blocks_of(const std::string& page, const std::string& language) {
    const std::regex fence("```" + language + "\\n([^`]*)```");
    std::vector<std::string> blocks;
    for (std::sregex_iterator it(page.begin(), page.end(), fence), end; it != end; ++it)
        blocks.push_back((*it)[1]);
    return blocks;
}

TEST(Documentation, ShowsScenesThatAreRight) {
    std::size_t scenes = 0;
    for (const auto& page : documented_pages())
        for (const std::string& text : blocks_of(read_file(page), "txtpb")) {
            ++scenes;
            EXPECT_NO_THROW(Scene::from_text(text).check()) << page << '\n' << text;
        }
    EXPECT_GE(scenes, 3U);
}

class Walkthrough : public ::testing::TestWithParam<const char*> {};

// From top to bottom in one folder, with the repository's examples and what the page itself shows.
TEST_P(Walkthrough, RunsAsItStandsThere) {
    const std::string page = read_file(repository / "docs" / GetParam());
    const Folder folder;
    std::filesystem::create_directory_symlink(repository / "examples", folder / "examples");
    const auto tables = blocks_of(page, "csv");
    if (!tables.empty()) write_file(folder / "fingers.csv", tables.front());
    for (const std::string& scene : blocks_of(page, "txtpb"))
        if (scene.starts_with("# fingers.txtpb")) write_file(folder / "fingers.txtpb", scene);

    static const std::regex alone("    afferent (run|plan|replay|calibrate|convert|tune|tuning) [^#]*");
    std::istringstream lines(page);
    int commands = 0;
    for (std::string line; std::getline(lines, line);) {
        std::smatch match;
        if (!std::regex_search(line, match, alone, std::regex_constants::match_continuous)) continue;
        const std::string typed = match.str().substr(std::string("    afferent").size());
        Process process({"-c", "cd '" + folder("") + "' && '" AFFERENT_PROGRAM "'" + typed}, "", "/bin/sh");
        EXPECT_EQ(process.wait(), 0) << line << '\n' << process.err();
        ++commands;
    }
    EXPECT_GT(commands, 0);
}

INSTANTIATE_TEST_SUITE_P(Documentation, Walkthrough,
                         ::testing::Values("start.md", "own_data.md", "link_size.md"), [](const auto& page) {
                             const std::string name = page.param;
                             return name.substr(0, name.find('.'));
                         });

}  // namespace
}  // namespace afferent
