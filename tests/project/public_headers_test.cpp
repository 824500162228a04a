// The headers that are installed: few, whole, and each says who includes it.
#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "tests/project/file_content.hpp"

namespace afferent {
namespace {

std::set<std::string> public_headers() {
    std::set<std::string> headers{"engine/afferent.h"};
    std::istringstream lines(content(AFFERENT_BINARY_DIR "/public_headers.txt"));
    for (std::string line; std::getline(lines, line);) headers.insert(line);
    return headers;
}

std::string source(const std::string& header) { return content(AFFERENT_SOURCE_DIR "/" + header); }

TEST(PublicHeaders, AreFew) {
    EXPECT_GE(public_headers().size(), 40U);
    EXPECT_LE(public_headers().size(), 60U);
}

TEST(PublicHeaders, IncludeNoOthers) {
    const std::set<std::string> headers = public_headers();
    static const std::regex include("#include \"afferent/([^\"]+)\"");
    std::size_t includes = 0;
    for (const std::string& header : headers) {
        const std::string text = source(header);
        for (std::sregex_iterator it(text.begin(), text.end(), include), end; it != end; ++it, ++includes)
            EXPECT_TRUE(headers.contains((*it)[1])) << header << " includes " << (*it)[1];
    }
    EXPECT_GT(includes, 50U);
}

TEST(PublicHeaders, SayWhoIncludesThem) {
    for (const std::string& header : public_headers()) {
        const std::string text = source(header);
        std::string comment;
        std::istringstream lines(text);
        for (std::string line; std::getline(lines, line) && line.find_first_of("/*") <= 1;)
            comment += line.substr(line.find_first_not_of("/* ") == std::string::npos
                                       ? line.size()
                                       : line.find_first_not_of("/* ")) +
                       ' ';
        EXPECT_NE(comment.find("nclude"), std::string::npos) << header << ": " << comment;
    }
}

}  // namespace
}  // namespace afferent
