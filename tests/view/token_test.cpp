#include "afferent/view/token.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

class ViewToken : public testing::Test {
  protected:
    ViewToken() {
        std::string name = (fs::temp_directory_path() / "afferent-token-XXXXXX").string();
        folder_ = ::mkdtemp(name.data());
        file_ = folder_ / "token";
    }
    ~ViewToken() override { fs::remove_all(folder_); }

    std::string content() const {
        std::ifstream in(file_);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    void write(const std::string& text,
               fs::perms permissions = fs::perms::owner_read | fs::perms::owner_write) {
        std::ofstream(file_) << text;
        fs::permissions(file_, permissions);
    }

    fs::path folder_;
    fs::path file_;
};

TEST_F(ViewToken, IsAnotherEachTime) {
    std::set<std::string> tokens;
    for (int i = 0; i < 100; ++i) tokens.insert(random_token());
    EXPECT_EQ(tokens.size(), 100U);
    for (const std::string& token : tokens) {
        EXPECT_EQ(token.size(), 32U);
        EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), std::string::npos);
    }
}

TEST_F(ViewToken, IsComparedInFull) {
    EXPECT_TRUE(same_token("abcd", "abcd"));
    EXPECT_FALSE(same_token("abcd", "abce"));
    EXPECT_FALSE(same_token("abcd", "abc"));
    EXPECT_FALSE(same_token("abcd", ""));
}

TEST_F(ViewToken, IsKeptInAFileForItsUserAlone) {
    const auto made = kept_token(file_);
    ASSERT_TRUE(made);
    EXPECT_EQ(content(), made.value());
    EXPECT_EQ(fs::status(file_).permissions(), fs::perms::owner_read | fs::perms::owner_write);
    EXPECT_EQ(value_or_throw(kept_token(file_)), made.value());
}

TEST_F(ViewToken, IsReplacedWhereOthersCouldHaveReadIt) {
    const std::string old = random_token();
    write(old, fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read);
    const std::string fresh = value_or_throw(kept_token(file_));
    EXPECT_NE(fresh, old);
    EXPECT_EQ(fs::status(file_).permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(ViewToken, IsReplacedWhereTheFileHoldsSomethingElse) {
    for (const std::string& text :
         {std::string(), std::string("short"), std::string(32, 'x'), random_token() + "0"}) {
        write(text);
        const std::string fresh = value_or_throw(kept_token(file_));
        EXPECT_NE(fresh, text);
        EXPECT_EQ(content(), fresh);
    }
}

TEST_F(ViewToken, FollowsNoLink) {
    const fs::path other = folder_ / "other";
    std::ofstream(other) << std::string(32, 'a');
    fs::permissions(other, fs::perms::owner_read | fs::perms::owner_write);
    fs::create_symlink(other, file_);
    EXPECT_NE(value_or_throw(kept_token(file_)), std::string(32, 'a'));
    EXPECT_FALSE(fs::is_symlink(file_));
}

TEST_F(ViewToken, SaysWhereItCannotBeKept) {
    const auto made = kept_token(folder_ / "absent" / "token");
    ASSERT_FALSE(made);
    EXPECT_NE(made.error().text.find("absent/token: cannot be made"), std::string::npos);
}

}  // namespace
}  // namespace afferent
