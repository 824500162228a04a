// Man pages and completions say what --help says, in the languages of those who read them.
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/apps/process.hpp"

namespace afferent {
namespace {

using Set = std::set<std::string>;

class Manual : public ::testing::Test {
  protected:
    static void SetUpTestSuite() {
        folder_ = new Folder;
        Process process({"manual", (*folder_)("share")});
        ASSERT_EQ(process.wait(), 0) << process.err();
    }
    static void TearDownTestSuite() { delete folder_; }

    static std::string share(const std::string& file) { return (*folder_)("share/" + file); }

    // The words with which each command is called, without the benchmarks, which are a program of their own.
    static std::vector<std::vector<std::string>> commands() {
        std::vector<std::vector<std::string>> all{{}};
        for (std::size_t i = 0; i < all.size(); ++i) {
            std::istringstream lines(help(all[i]));
            bool listed = false;
            static const std::regex name("  ([a-z]+) .*");
            for (std::string line; std::getline(lines, line);) {
                listed = listed ? !line.empty() : line == "Subcommands:";
                std::smatch match;
                if (!listed || !std::regex_match(line, match, name) || match[1] == "bench") continue;
                all.push_back(all[i]);
                all.back().push_back(match[1]);
            }
        }
        return all;
    }
    static std::string help(std::vector<std::string> command) {
        command.push_back("--help");
        Process process(command);
        EXPECT_EQ(process.wait(), 0);
        return process.out();
    }
    static Set options_in_help(const std::vector<std::string>& command) {
        const std::string text = help(command);
        static const std::regex option("\n  (?:-h,)?(--[a-z-]+)");
        Set names;
        for (std::sregex_iterator it(text.begin(), text.end(), option), end; it != end; ++it)
            names.insert((*it)[1]);
        EXPECT_TRUE(names.contains("--help")) << text;
        return names;
    }
    static std::string words(const std::vector<std::string>& command) {
        std::string text = "afferent";
        for (const std::string& word : command) text += ' ' + word;
        return text;
    }

    // What a shell's script prints; nothing where there is no such shell. It finds no settings of a user.
    static std::optional<std::string> printed_by(const std::string& shell, const std::string& script) {
        const std::string begin = "command -v " + shell + " >/dev/null || exit 77; export HOME='" +
                                  (*folder_)("") + "'; unset XDG_CONFIG_HOME XDG_DATA_HOME; exec " + shell;
        Process process({"-c", begin + " \"$@\"", "sh", "-c", script}, "", "/bin/sh");
        const int code = process.wait();
        if (code == 77) return std::nullopt;
        EXPECT_EQ(code, 0) << script;
        EXPECT_EQ(process.err(), "") << script;
        return process.out();
    }
    static Set lines(const std::string& text) {
        std::istringstream in(text);
        Set all;
        for (std::string line; std::getline(in, line);) all.insert(line);
        return all;
    }

  private:
    inline static Folder* folder_ = nullptr;
};

TEST_F(Manual, HasAPageForEachCommandWithAllOfItsOptions) {
    const auto all = commands();
    ASSERT_GT(all.size(), 10U);
    for (const auto& command : all) {
        std::string page = words(command);
        std::ranges::replace(page, ' ', '-');
        const std::string text =
            std::regex_replace(read_file(share("man/man1/" + page + ".1")), std::regex(R"(\\-)"), "-");
        ASSERT_FALSE(text.empty()) << page;
        for (const std::string& option : options_in_help(command))
            EXPECT_NE(text.find("\\fB" + option + "\\fR"), std::string::npos) << page << ' ' << option;
    }
}

TEST_F(Manual, PagesAreSetWithoutAWarning) {
    const auto out =
        printed_by("bash", "command -v groff >/dev/null || exit 0; for page in " + share("man/man1") +
                               "/*.1; do groff -Tutf8 -P-cbou -ww -man \"$page\"; done");
    if (!out || out->empty()) GTEST_SKIP() << "no bash or no groff";
    EXPECT_NE(out->find("SYNOPSIS"), std::string::npos);
}

TEST_F(Manual, BashCompletesCommandsOptionsAndFiles) {
    const std::string begin =
        "cd " + share("") +
        " && touch 'a scene.txtpb'; source bash-completion/completions/afferent; complete() {\n"
        "    COMP_WORDS=(\"$@\") COMP_CWORD=$(($# - 1)); _afferent; printf '%s\\n' \"${COMPREPLY[@]}\"; }\n";
    if (!printed_by("bash", "")) GTEST_SKIP() << "no bash";
    for (const auto& command : commands()) {
        const auto proposed = printed_by("bash", begin + "complete " + words(command) + " -");
        EXPECT_EQ(lines(proposed.value()), options_in_help(command)) << words(command);
    }
    const auto answer = [&](const std::string& line) {
        return lines(printed_by("bash", begin + "complete " + line).value());
    };
    EXPECT_EQ(answer("afferent co"), (Set{"convert", "coprocessor"}));
    EXPECT_EQ(answer("afferent link ''"), Set{"status"});
    EXPECT_EQ(answer("afferent link status --w"), Set{"--watch"});
    EXPECT_EQ(answer("afferent run a"), Set{"a scene.txtpb"});
    EXPECT_EQ(answer("afferent run run a"), Set{"a scene.txtpb"});
    EXPECT_EQ(answer("afferent run --out = a"), Set{"a scene.txtpb"});
    EXPECT_EQ(answer("afferent run --seed ''"), Set{""});
}

TEST_F(Manual, ZshReadsItsCompletions) {
    const std::string file = share("zsh/site-functions/_afferent");
    if (!printed_by("zsh", "true")) GTEST_SKIP() << "no zsh";
    EXPECT_EQ(printed_by("zsh", "zsh -f -n " + file), "");
    // _arguments would get the words that describe each option.
    const auto given = printed_by(
        "zsh", "compdef() { }; _arguments() { print -rl -- \"$@\" }; source " + file + " && _afferent_run");
    ASSERT_TRUE(given);
    for (const std::string& option : options_in_help({"run"}))
        EXPECT_NE(given->find(option), std::string::npos) << option;
}

TEST_F(Manual, FishCompletesCommandsOptionsAndFiles) {
    if (!printed_by("fish", "true")) GTEST_SKIP() << "no fish";
    const std::string begin =
        "cd " + share("") + "; touch scene.txtpb; source fish/vendor_completions.d/afferent.fish; ";
    const auto answer = [&](const std::string& line) {
        Set names;
        for (const std::string& each :
             lines(printed_by("fish", begin + "complete -C '" + line + "'").value()))
            names.insert(each.substr(0, each.find('\t')));
        return names;
    };
    for (const auto& command : commands()) {
        Set proposed = answer(words(command) + " --");
        EXPECT_EQ(proposed, options_in_help(command)) << words(command);
    }
    EXPECT_EQ(answer("afferent co"), (Set{"convert", "coprocessor"}));
    EXPECT_EQ(answer("afferent link "), Set{"status"});
    EXPECT_EQ(answer("afferent run scen"), Set{"scene.txtpb"});
    EXPECT_EQ(answer("afferent run --out scen"), Set{"scene.txtpb"});
}

}  // namespace
}  // namespace afferent
