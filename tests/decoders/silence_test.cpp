#include "afferent/decoders/silence.hpp"

#include <gtest/gtest.h>

#include "tests/since_start.hpp"

namespace afferent {
namespace {

TEST(AllowedRate, IsThatOfASpikeThatWouldComeNow) {
    EXPECT_EQ(allowed_hz(at(0ms), at(0ms), at(250ms), 100ms), 4);
    EXPECT_EQ(allowed_hz(at(0ms), at(0ms), at(99ms), 100ms), 0) << "the spike is still counted";
    EXPECT_EQ(allowed_hz(at(0ms), at(0ms), at(100ms), 100ms), 10);
    EXPECT_EQ(allowed_hz(at(0ms), at(0ms), at(1s) - 1ns, 100ms), 1 / (1 - 1e-9));
    EXPECT_EQ(allowed_hz(at(0ms), at(0ms), at(1s), 100ms), 0) << "at rest";
    EXPECT_EQ(allowed_hz(never_fired, at(0ms), at(250ms), 100ms), 0);
}

TEST(AllowedRate, CountsTheKnownSilenceAlone) {
    EXPECT_EQ(allowed_hz(at(0ms), at(200ms), at(250ms), 100ms), 20);
    EXPECT_NEAR(allowed_hz(at(0ms), at(250ms), at(250ms), 100ms), 1e6, 1e-3) << "a microsecond at least";
}

}  // namespace
}  // namespace afferent
