#include "afferent/view/access.hpp"

#include <gtest/gtest.h>

#include "afferent/view/token.hpp"

namespace afferent {
namespace {

const std::string right_token = "0123456789abcdef0123456789abcdef";
constexpr std::uint16_t view_port = 8123;

struct Asked {
    const char* what;
    std::string method;
    std::string target;
    std::vector<std::string_view> hosts;
    std::vector<std::string_view> origins;
    bool upgrades;
    unsigned status;
};

TEST(ViewAccess, GivesThePageToItsOwnAddressAlone) {
    const std::string page = "/" + right_token + "/";
    const std::vector<Asked> table{
        {"the page", "GET", page, {"127.0.0.1:8123"}, {}, false, 200},
        {"by the loopback's name", "GET", page, {"localhost:8123"}, {}, false, 200},
        {"a file of it", "GET", page + "view.js", {"127.0.0.1:8123"}, {}, false, 200},
        {"a file with its own origin",
         "GET",
         page,
         {"localhost:8123"},
         {"http://localhost:8123"},
         false,
         200},
        {"a name that leads here", "GET", page, {"evil.example:8123"}, {}, false, 403},
        {"a name that ends alike", "GET", page, {"evil.localhost:8123"}, {}, false, 403},
        {"a name that begins alike", "GET", page, {"127.0.0.1.evil.example:8123"}, {}, false, 403},
        {"a port that begins alike", "GET", page, {"127.0.0.1:81234"}, {}, false, 403},
        {"a port that ends alike", "GET", page, {"localhost:18123"}, {}, false, 403},
        {"the loopback's name that begins alike",
         "GET",
         page,
         {"localhost:8123.evil.example"},
         {},
         false,
         403},
        {"another port", "GET", page, {"127.0.0.1:8124"}, {}, false, 403},
        {"no port", "GET", page, {"127.0.0.1"}, {}, false, 403},
        {"another address of the loopback", "GET", page, {"127.0.0.2:8123"}, {}, false, 403},
        {"IPv6", "GET", page, {"[::1]:8123"}, {}, false, 403},
        {"upper case", "GET", page, {"LOCALHOST:8123"}, {}, false, 403},
        {"an empty host", "GET", page, {""}, {}, false, 403},
        {"no host", "GET", page, {}, {}, false, 400},
        {"two hosts", "GET", page, {"127.0.0.1:8123", "127.0.0.1:8123"}, {}, false, 400},
        {"another origin", "GET", page, {"127.0.0.1:8123"}, {"http://evil.example"}, false, 403},
        {"an origin by the other name",
         "GET",
         page,
         {"127.0.0.1:8123"},
         {"http://localhost:8123"},
         false,
         403},
        {"an origin that begins alike",
         "GET",
         page,
         {"127.0.0.1:8123"},
         {"http://127.0.0.1:8123.evil.example"},
         false,
         403},
        {"an origin that is a part of it", "GET", page, {"127.0.0.1:8123"}, {"http://127.0.0.1"}, false, 403},
        {"an origin of a port that begins alike",
         "GET",
         page,
         {"127.0.0.1:8123"},
         {"http://127.0.0.1:81234"},
         false,
         403},
        {"an empty origin", "GET", page, {"127.0.0.1:8123"}, {""}, false, 403},
        {"another scheme", "GET", page, {"127.0.0.1:8123"}, {"https://127.0.0.1:8123"}, false, 403},
        {"no origin, in words", "GET", page, {"127.0.0.1:8123"}, {"null"}, false, 403},
        {"two origins",
         "GET",
         page,
         {"127.0.0.1:8123"},
         {"http://127.0.0.1:8123", "http://evil.example"},
         false,
         400},
        {"a post", "POST", page, {"127.0.0.1:8123"}, {}, false, 405},
        {"a wrong token", "GET", "/0123456789abcdef0123456789abcdee/", {"127.0.0.1:8123"}, {}, false, 404},
        {"a part of the token", "GET", "/0123456789abcdef/", {"127.0.0.1:8123"}, {}, false, 404},
        {"more than the token", "GET", "/" + right_token + "0/", {"127.0.0.1:8123"}, {}, false, 404},
        {"no token", "GET", "/", {"127.0.0.1:8123"}, {}, false, 404},
        {"a token without its slash", "GET", "/" + right_token, {"127.0.0.1:8123"}, {}, false, 404},
        {"an empty target", "GET", "", {"127.0.0.1:8123"}, {}, false, 400},
        {"a whole address", "GET", "http://127.0.0.1:8123" + page, {"127.0.0.1:8123"}, {}, false, 400},
        {"an upgrade of the page", "GET", page, {"127.0.0.1:8123"}, {}, true, 400},
        {"the socket without an upgrade",
         "GET",
         page + "socket",
         {"127.0.0.1:8123"},
         {"http://127.0.0.1:8123"},
         false,
         426},
        {"the socket without an origin", "GET", page + "socket", {"127.0.0.1:8123"}, {}, true, 403},
        {"the socket for another origin",
         "GET",
         page + "socket",
         {"127.0.0.1:8123"},
         {"http://evil.example"},
         true,
         403},
        {"the socket", "GET", page + "socket", {"127.0.0.1:8123"}, {"http://127.0.0.1:8123"}, true, 200},
    };
    const ViewAccess access(right_token, view_port);
    for (const Asked& asked : table) {
        const auto answer = access({asked.method, asked.target, asked.hosts, asked.origins, asked.upgrades});
        EXPECT_EQ(answer.status, asked.status) << asked.what;
        EXPECT_EQ(answer.is_socket, asked.status == 200 && asked.upgrades) << asked.what;
    }
    EXPECT_EQ(access({"GET", page, {"localhost:8123"}, {}, false}).file, "index.html");
    EXPECT_EQ(access({"GET", page + "../x", {"localhost:8123"}, {}, false}).file,
              "../x");  // of no embedded file
    EXPECT_EQ(access.url(), "http://127.0.0.1:8123" + page);
}

TEST(ViewAccess, TakesNoHostThatWhitespaceMakesDoubtful) {
    const std::string line = "GET / HTTP/1.1\r\n";
    for (const char* fields : {"Host: 127.0.0.1:8123", "Host:127.0.0.1:8123\r\nAccept: a, b",
                               "HOST: \t127.0.0.1:8123", "Accept: a \r\nHost: 127.0.0.1:8123", "", "Host:"})
        EXPECT_TRUE(is_unambiguous(line + fields)) << fields;
    for (const char* fields :
         {"Host: 127.0.0.1:8123 ", "Host: 127.0.0.1:8123\t", "Host: 127.0.0.1:8123 evil.example",
          "hOST: 127.0.0.1:8123\r\n evil.example", "Host: 127.0.0.1:8123\r\n\t", "Host:\r\n 127.0.0.1:8123",
          "Host: 127.0.0.1:8123\nevil: 1", "Host: 127.0.0.1:8123\r",
          "Accept: a,\r\n b\r\nHost: localhost:8123"})
        EXPECT_FALSE(is_unambiguous(line + fields)) << fields;
}

TEST(ViewAccess, LetsThePageLoadNothingButItsOwn) {
    const std::string policy = content_policy("localhost:8123");
    EXPECT_TRUE(policy.starts_with("default-src 'none';")) << policy;
    EXPECT_NE(policy.find("connect-src ws://localhost:8123;"), std::string::npos) << policy;
    EXPECT_EQ(policy.find("unsafe"), std::string::npos) << policy;
    EXPECT_NE(policy.find("frame-ancestors 'none'"), std::string::npos) << policy;
}

}  // namespace
}  // namespace afferent
