#include "afferent/nodes/hello.hpp"

#include <gtest/gtest.h>

namespace afferent {
namespace {

Result<LinkAddress> address(const std::string& link, bool lockstep) {
    return address_of(make_plan(Scene::from_text("link { " + link + " }")), LinkEnd::hand, lockstep);
}

TEST(AddressOf, ALinkInLockstepLosesNothing) {
    EXPECT_TRUE(address("tcp {}", true));
    EXPECT_TRUE(address("udp {}", false));
    EXPECT_TRUE(address("tcp {} channel { latency_ms: 1 }", false));
    for (const std::string link : {"udp {}", "tcp {} channel { latency_ms: 1 }"}) {
        const auto refused = address(link, true);
        ASSERT_FALSE(refused) << link;
        EXPECT_EQ(refused.error().kind, Error::Kind::not_allowed);
        EXPECT_NE(refused.error().text.find("--lockstep waits for every message"), std::string::npos);
    }
}

TEST(AddressOf, IsThatOfTwoProcesses) {
    for (const std::string link : {"in_process {}", "file { path: \"a.events\" }"}) {
        const auto refused = address(link, false);
        ASSERT_FALSE(refused) << link;
        EXPECT_EQ(refused.error().kind, Error::Kind::not_allowed);
    }
}

}  // namespace
}  // namespace afferent
