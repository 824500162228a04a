// README and docs/ hold together: links lead somewhere, and code that is shown is code that is compiled and
// run.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/project/file_content.hpp"

namespace afferent {
namespace {

namespace files = std::filesystem;

const files::path checkout = AFFERENT_SOURCE_DIR;

std::vector<files::path> markdown_pages() {
    std::vector<files::path> all{checkout / "README.md", checkout / "CHANGELOG.md",
                                 checkout / "bench" / "README.md"};
    for (const auto& entry : files::directory_iterator(checkout / "docs"))
        if (entry.path().extension() == ".md") all.push_back(entry.path());
    return all;
}

struct Block {
    std::string language;
    std::string code;
};

// The fenced blocks of a page, and the page without them.
std::vector<Block> fenced_blocks(const std::string& page, std::string* prose = nullptr) {
    std::vector<Block> blocks;
    std::istringstream lines(page);
    bool inside = false;
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with("```")) {
            inside = !inside;
            if (inside) blocks.push_back({line.substr(3), ""});
        } else if (inside) {
            blocks.back().code += line + '\n';
        } else if (prose) {
            *prose += line + '\n';
        }
    }
    EXPECT_FALSE(inside) << "a block has no end";
    return blocks;
}

// As GitHub and the site name the place of a heading.
std::set<std::string> places_in(const std::string& page) {
    std::string prose;
    fenced_blocks(page, &prose);
    std::istringstream lines(prose);
    std::set<std::string> places;
    for (std::string line; std::getline(lines, line);) {
        if (!line.starts_with('#')) continue;
        std::string place;
        for (const char letter : line.substr(line.find_first_not_of("# "))) {
            if (letter == ' ')
                place += '-';
            else if (std::isalnum(static_cast<unsigned char>(letter)) || letter == '-' || letter == '_')
                place += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
        }
        places.insert(place);
    }
    return places;
}

TEST(Documentation, LinksToWhatIsThere) {
    static const std::regex link(R"(\]\(([^)#:\s]*)(?:#([^)\s]*))?\))");
    std::size_t links = 0;
    for (const files::path& page : markdown_pages()) {
        std::string prose;
        fenced_blocks(content(page), &prose);
        for (std::sregex_iterator it(prose.begin(), prose.end(), link), end; it != end; ++it, ++links) {
            const files::path target = (*it)[1].length() == 0 ? page : page.parent_path() / (*it)[1].str();
            EXPECT_TRUE(files::exists(target)) << page << " links to " << it->str();
            if ((*it)[2].matched && target.extension() == ".md") {
                EXPECT_TRUE(places_in(content(target)).contains((*it)[2]))
                    << page << " links to " << it->str();
            }
        }
    }
    EXPECT_GT(links, 100U);
}

TEST(Documentation, NamesScriptsThatCanBeRun) {
    static const std::regex script(R"((?:^|[\s`])(?:\./)?((?:scripts/)?[a-z-]+\.sh)\b)");
    std::set<std::string> named;
    for (const files::path& page : markdown_pages()) {
        if (page.filename() == "CHANGELOG.md") continue;
        const std::string text = content(page);
        for (std::sregex_iterator it(text.begin(), text.end(), script), end; it != end; ++it)
            named.insert((*it)[1]);
    }
    EXPECT_GE(named.size(), 4U);
    for (const std::string& name : named) {
        EXPECT_TRUE(files::is_regular_file(checkout / name)) << name;
        EXPECT_NE(files::status(checkout / name).permissions() & files::perms::owner_exec, files::perms::none)
            << name;
    }
}

TEST(Documentation, ShowsCodeThatIsInTheExamples) {
    std::vector<std::string> examples;
    for (const auto& entry : files::directory_iterator(checkout / "examples"))
        if (entry.is_regular_file() && entry.path().extension() != ".png")
            examples.push_back(content(entry.path()));
    std::size_t shown = 0;
    for (const files::path& page : markdown_pages()) {
        for (const auto& [language, code] : fenced_blocks(content(page))) {
            const bool is_embed = page.filename() == "embed.md" && language == "python";
            if (language != "cpp" && language != "c" && !is_embed) continue;
            ++shown;
            EXPECT_TRUE(std::ranges::any_of(
                examples, [&](const std::string& file) { return file.find(code) != std::string::npos; }))
                << page << " shows code that is in no file of examples/:\n"
                << code;
        }
    }
    EXPECT_GT(shown, 8U);
}

}  // namespace
}  // namespace afferent
