#include "afferent/io/links/watchdog.hpp"

#include <gtest/gtest.h>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

const MonotonicTime start = std::chrono::steady_clock::now();

TEST(Watchdog, FreezesAtTheFirstThresholdAndThawsWithTheNextPacket) {
    Watchdog watchdog(60ms, 150ms, start);
    EXPECT_EQ(watchdog.state(start + 60ms - 1ns), GripState::operating);
    EXPECT_EQ(watchdog.state(start + 60ms), GripState::frozen);
    watchdog.heard(start + 100ms);
    EXPECT_EQ(watchdog.state(start + 100ms), GripState::operating);
    EXPECT_EQ(watchdog.state(start + 160ms), GripState::frozen);
    EXPECT_TRUE(watchdog.reason().empty());
}

TEST(Watchdog, IsSafeForGoodPastTheSecond) {
    Watchdog watchdog(60ms, 150ms, start);
    EXPECT_EQ(watchdog.state(start + 150ms), GripState::safe);
    EXPECT_EQ(watchdog.reason(), "no packet for 150 ms");
    watchdog.heard(start + 151ms);
    EXPECT_EQ(watchdog.state(start + 151ms), GripState::safe);
}

TEST(Watchdog, IsSafeEvenIfNobodyAskedDuringTheSilence) {
    Watchdog watchdog(60ms, 150ms, start);
    watchdog.heard(start + 10s);
    EXPECT_EQ(watchdog.state(start + 10s), GripState::safe);
}

TEST(Watchdog, KeepsTheFirstReason) {
    Watchdog watchdog(60ms, 150ms, start);
    watchdog.trip("the motor is too hot");
    EXPECT_EQ(watchdog.state(start), GripState::safe);
    watchdog.trip("the battery is empty");
    EXPECT_EQ(watchdog.state(start + 1s), GripState::safe);
    EXPECT_EQ(watchdog.reason(), "the motor is too hot");
}

TEST(Watchdog, RefusesThresholdsInTheWrongOrder) {
    EXPECT_THROW(Watchdog(0ms, 150ms, start), ParameterError);
    EXPECT_THROW(Watchdog(60ms, 60ms, start), ParameterError);
}

}  // namespace
}  // namespace afferent
