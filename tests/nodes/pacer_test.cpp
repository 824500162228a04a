// Scene time on a clock.
#include "afferent/nodes/pacer.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace afferent {
namespace {

constexpr MonotonicTime instant(std::chrono::hours(5));

TEST(Pacer, KeepsSceneTimeToTheNanosecond) {
    const Pacer pacer(instant, scene_start + 3s);
    EXPECT_EQ(pacer.wall(scene_start + 3s), instant);
    EXPECT_EQ(pacer.wall(scene_start), instant - 3s);
    // A day later, where a double still has its nanoseconds.
    EXPECT_EQ(pacer.wall(scene_start + 24h + 1ns), instant + 24h - 3s + 1ns);
    EXPECT_EQ(pacer.scene_time(instant + 24h + 1ns), scene_start + 24h + 3s + 1ns);
}

TEST(Pacer, RunsAsFastAsItIsTold) {
    const Pacer pacer(instant, scene_start + 1s, 4);
    EXPECT_EQ(pacer.wall(scene_start + 5s), instant + 1s);
    EXPECT_EQ(pacer.scene_time(instant + 1s), scene_start + 5s);
}

TEST(Pacer, IsNeverEarly) {
    for (const double speed : {0.3, 1 - 500e-6, 1.0, 1 + 500e-6, 4.0}) {
        const Pacer pacer(instant, scene_start, speed);
        for (int k = 1; k < 1000; ++k) {
            const TimePoint due = scene_start + k * Duration(1'000'003);
            EXPECT_GE(pacer.scene_time(pacer.wall(due)), due);
            EXPECT_LE(pacer.scene_time(pacer.wall(due) - Duration(2)), due);
        }
    }
}

TEST(Pacer, ComesCloserToAPeerWithoutAJump) {
    for (const Duration ahead : {Duration(10ms), Duration(-10ms), Duration(100us)}) {
        Pacer pacer(instant);
        MonotonicTime at = instant;
        Duration left = ahead;
        for (int i = 0; i < 240; ++i) {
            const TimePoint before = pacer.scene_time(at);
            pacer.steer(at, left);
            EXPECT_EQ(pacer.scene_time(at), before);
            at += 250ms;
            const Duration moved = pacer.scene_time(at) - before - 250ms;
            EXPECT_LE(std::chrono::abs(moved), 500us) << "two thousandths";
            left -= moved;
        }
        EXPECT_LT(std::chrono::abs(left), 1us);
        pacer.steer(at, std::nullopt);
        EXPECT_EQ(pacer.scene_time(at + 10s) - pacer.scene_time(at), 10s);
    }
}

// The response of a critically damped controller of second order, s/(s + 1/2)², to a drift that begins: it is
// t·exp(-t/2) times the drift, which is at most 2/e seconds of it.
TEST(Pacer, FollowsAPeerWhoseClockDriftsAndIsNotLeftBehind) {
    for (const double drift : {1000e-6, -1000e-6}) {
        Pacer pacer(instant);
        double left_s = 0;
        MonotonicTime at = instant;
        for (int i = 1; i <= 600; ++i) {
            const TimePoint before = pacer.scene_time(at);
            at += 50ms;
            left_s += (1 + drift) * 50e-3 - seconds(pacer.scene_time(at) - before);
            pacer.steer(at, from_seconds(left_s));
            const double t = 50e-3 * i;
            // The controller acts every 50 ms: for so long the drift goes on.
            EXPECT_NEAR(left_s, drift * t * std::exp(-t / 2), std::abs(drift) * 50e-3) << t;
        }
        EXPECT_LT(std::abs(left_s), 1e-6);
    }
}

TEST(Pacer, CountsWhatIsDoneMoreThanAMillisecondLate) {
    Pacer pacer(instant);
    pacer.did(scene_start + 1s, instant + 1s + 1ms);
    EXPECT_EQ(pacer.missed_deadlines(), 0U);
    pacer.did(scene_start + 2s, instant + 2s + 1ms + 1ns);
    pacer.did(scene_start + 3s, instant + 3s);
    EXPECT_EQ(pacer.missed_deadlines(), 1U);
    EXPECT_EQ(pacer.worst_lag(), 1ms + 1ns);
}

}  // namespace
}  // namespace afferent
