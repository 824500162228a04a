// How long links and sessions wait for a peer, as the scene says.
#include "afferent/nodes/hello.hpp"

#include <gtest/gtest.h>

namespace afferent {
namespace {

using std::chrono::milliseconds;

Plan with_safe_ms(const std::string& safe_ms) {
    return make_plan(Scene::from_text("link { udp {} freeze_ms: 100 safe_ms: " + safe_ms + " }"));
}

TEST(Hello, APeerIsNotGivenUpBeforeTheSafeState) {
    EXPECT_EQ(link_options(with_safe_ms("4000"), false).silence_limit, milliseconds(4000));
    EXPECT_EQ(session_limits(with_safe_ms("4000"), false).silence, milliseconds(4000));
}

TEST(Hello, APeerHasASecondHoweverSoonTheSafeStateIs) {
    EXPECT_EQ(link_options(with_safe_ms("150"), false).silence_limit, milliseconds(1000));
    EXPECT_EQ(session_limits(with_safe_ms("150"), false).silence, milliseconds(1000));
}

TEST(Hello, LockstepWaitsForAPeerHoweverLongItIsSilent) {
    EXPECT_EQ(session_limits(with_safe_ms("150"), true).silence, milliseconds(0));
    EXPECT_EQ(link_options(with_safe_ms("150"), true).alive_limit, milliseconds(0));
}

}  // namespace
}  // namespace afferent
