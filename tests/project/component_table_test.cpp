// The components in the documentation are those of the build, with what each of them links.
#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <utility>

#include "tests/project/file_content.hpp"

namespace afferent {
namespace {

using NameSet = std::set<std::string>;
using Table = std::map<std::string, std::pair<NameSet, NameSet>>;

NameSet names_in(const std::string& text) {
    static const std::regex word("[a-z0-9_]+");
    return {std::sregex_token_iterator(text.begin(), text.end(), word), std::sregex_token_iterator()};
}

// component|what it builds on|libraries
Table of_build() {
    Table table;
    std::istringstream lines(content(AFFERENT_BINARY_DIR "/components.txt"));
    static const std::regex row("([^|]*)[|]([^|]*)[|]([^|]*)");
    std::smatch match;
    for (std::string line; std::getline(lines, line);)
        if (std::regex_match(line, match, row)) table[match[1]] = {names_in(match[2]), names_in(match[3])};
    return table;
}

Table of_documentation() {
    Table table;
    std::istringstream lines(content(AFFERENT_SOURCE_DIR "/docs/install.md"));
    static const std::regex row("[|] `([a-z0-9_]+)` [|][^|]*[|]([^|]*)[|]([^|]*)[|]");
    std::smatch match;
    for (std::string line; std::getline(lines, line);)
        if (std::regex_match(line, match, row)) table[match[1]] = {names_in(match[2]), names_in(match[3])};
    return table;
}

TEST(ComponentTable, SaysWhatEachLinks) {
    const Table built = of_build();
    const Table documented = of_documentation();
    ASSERT_GT(built.size(), 10U);
    for (const auto& [name, links] : built) {
        ASSERT_TRUE(documented.contains(name)) << "docs/install.md has no row of the component " << name;
        EXPECT_EQ(documented.at(name).first, links.first) << name << " builds on";
        EXPECT_EQ(documented.at(name).second, links.second) << name << " links";
    }
    EXPECT_EQ(built.size(), documented.size());
}

}  // namespace
}  // namespace afferent
