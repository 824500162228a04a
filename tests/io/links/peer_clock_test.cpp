// Two clocks in virtual time, with a link between them that is late, jitters, and is late in one direction.
#include "afferent/io/links/peer_clock.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace afferent {
namespace {

// A machine that has been up for a while.
constexpr MonotonicTime start{std::chrono::hours(1)};

class TwoClocks {
  public:
    PeerClock estimate;
    MonotonicTime now = start;
    double drift = 0;
    // How long a message takes to the peer, and back.
    std::function<Duration()> there = [] { return Duration(200us); };
    std::function<Duration()> back = [] { return Duration(200us); };
    Duration every = 250ms;
    Duration worst_error{};

    // The true time of the peer's clock, by which it is judged.
    TimePoint peer(MonotonicTime time) const {
        const auto since = static_cast<double>((time - start).count());
        return scene_start + 500ms + (time - start) + Duration(std::llround(drift * since));
    }

    bool echo() {
        const MonotonicTime sent = now;
        const MonotonicTime answered = sent + there();
        const MonotonicTime received = answered + back();
        const bool used = estimate.echoed(sent, received, peer(answered));
        now = std::max(sent + every, received);
        return used;
    }

    // Judges the estimate just before each echo, when it is oldest.
    void run_for(Duration duration) {
        for (const MonotonicTime end = now + duration; now < end;) {
            ASSERT_TRUE(echo());
            const Duration error = std::chrono::abs(estimate.time(now) - peer(now));
            ASSERT_LE(error, estimate.uncertainty(now)) << "at " << seconds(Duration(now - start)) << " s";
            worst_error = std::max(worst_error, error);
        }
    }
};

TEST(PeerClock, IsKnownToHalfARoundTripAfterOneEcho) {
    TwoClocks clocks;
    EXPECT_FALSE(clocks.estimate.known());
    clocks.there = [] { return Duration(3ms); };
    clocks.back = [] { return Duration(1ms); };
    clocks.every = Duration::zero();
    clocks.echo();
    EXPECT_TRUE(clocks.estimate.known());
    EXPECT_NEAR(Milliseconds(clocks.estimate.uncertainty(clocks.now)).count(), 2, 0.01);
    // The middle: as if it had taken two milliseconds each way.
    EXPECT_NEAR(Milliseconds(clocks.estimate.time(clocks.now) - clocks.peer(clocks.now)).count(), 1, 0.01);
    EXPECT_EQ(clocks.estimate.round_trip(), 4ms);
}

TEST(PeerClock, FollowsClocksThatDriftApartForHours) {
    for (const double drift : {1000e-6, -1000e-6, 100e-6, -100e-6, 20e-6, 0.0}) {
        std::mt19937_64 random(1);
        std::exponential_distribution<double> jitter_ms(1 / 2.0);
        TwoClocks clocks;
        clocks.drift = drift;
        clocks.there =
            clocks.back = [&] { return Duration(300us) + rounded(Interval(1e6 * jitter_ms(random))); };
        clocks.run_for(std::chrono::hours(4));
        if (testing::Test::HasFatalFailure()) return;
        // The two clocks are 14.4 s apart by now at 1000 ppm.
        EXPECT_LT(clocks.worst_error, 4ms) << drift;
        EXPECT_NEAR(clocks.estimate.drift() * 1e6, drift * 1e6, 15);
        EXPECT_EQ(clocks.estimate.refused(), 0U);
        EXPECT_LT(clocks.estimate.round_trip(), 2ms);
    }
}

TEST(PeerClock, IsNotMisledByBurstsThatHoldUpOneDirection) {
    for (const bool is_there : {true, false}) {
        TwoClocks clocks;
        clocks.drift = 100e-6;
        const auto burst = [&] {
            const Duration since = clocks.now - start;
            return Duration(200us) + (since % 60s < 15s && since > 60s ? Duration(80ms) : Duration::zero());
        };
        (is_there ? clocks.there : clocks.back) = burst;
        clocks.run_for(std::chrono::hours(1));
        if (testing::Test::HasFatalFailure()) return;
        // Fifteen seconds with bounds on one side: the other widens by 500 ppm, and the middle moves by half.
        EXPECT_LT(clocks.worst_error, 4ms);
    }
}

TEST(PeerClock, KnowsALinkThatIsSlowFromTheVeryStart) {
    TwoClocks clocks;
    clocks.there = clocks.back = [] { return Duration(115ms); };
    clocks.run_for(10s);
    EXPECT_EQ(clocks.estimate.round_trip(), 230ms);
    // A packet that is stamped and sent now arrives in 115 ms, and its age is known then.
    const TimePoint stamp = clocks.peer(clocks.now);
    EXPECT_NEAR(Milliseconds(clocks.estimate.age(stamp, clocks.now + 115ms)).count(), 115, 0.2);
}

TEST(PeerClock, GoesOnByTheDriftItKnowsWhereNoEchoComes) {
    TwoClocks clocks;
    clocks.drift = 100e-6;
    clocks.run_for(std::chrono::minutes(3));
    clocks.now += 60s;
    const Duration error = std::chrono::abs(clocks.estimate.time(clocks.now) - clocks.peer(clocks.now));
    EXPECT_LT(error, 500us) << "6 ms without the drift";
    // It tells how uncertain it is by then.
    EXPECT_NEAR(Milliseconds(clocks.estimate.uncertainty(clocks.now)).count(), 30, 1);
    EXPECT_TRUE(clocks.echo());
    EXPECT_LT(clocks.estimate.uncertainty(clocks.now), 1ms);
}

TEST(PeerClock, RefusesAndCountsAnEchoFromFarOff) {
    TwoClocks clocks;
    clocks.run_for(10s);
    for (const Duration off : {Duration(2s), Duration(-2s), Duration(50ms)}) {
        EXPECT_FALSE(clocks.estimate.echoed(clocks.now, clocks.now + 1ms, clocks.peer(clocks.now) + off));
        const Duration error = clocks.estimate.time(clocks.now) - clocks.peer(clocks.now);
        EXPECT_LT(std::chrono::abs(error), 1ms);
    }
    EXPECT_EQ(clocks.estimate.refused(), 3U);
    clocks.run_for(10s);
}

TEST(PeerClock, HasTheShortestRoundTripOfLate) {
    TwoClocks clocks;
    for (const auto& [way, shortest] :
         {std::pair{Duration(2ms), Duration(4ms)}, {500us, 1ms}, {1500us, 1ms}, {700us, 1ms}}) {
        clocks.there = clocks.back = [way = way] { return way; };
        ASSERT_TRUE(clocks.echo());
        EXPECT_EQ(clocks.estimate.round_trip(), shortest);
    }
}

TEST(PeerClock, StartsOverWhereThePeersClockHasJumped) {
    TwoClocks clocks;
    clocks.run_for(10s);
    const auto echo = [&] {
        clocks.now += 250ms;
        return clocks.estimate.echoed(clocks.now, clocks.now + 1ms, clocks.peer(clocks.now) + 60s);
    };
    int refused = 0;
    while (!echo()) ASSERT_LE(++refused, 8);
    EXPECT_EQ(refused, 8);
    EXPECT_LT(std::chrono::abs(clocks.estimate.time(clocks.now) - clocks.peer(clocks.now) - 60s), 1ms);
    EXPECT_TRUE(echo());
}

// A peer may say anything; the session has checked that it is a scene time.
TEST(PeerClock, SurvivesAnyEcho) {
    std::mt19937_64 random(1);
    PeerClock estimate;
    MonotonicTime now = start;
    for (int i = 0; i < 100'000; ++i) {
        now += Duration(static_cast<Duration::rep>(random() % 10'000'000'000));
        const TimePoint peer =
            scene_start + Duration(static_cast<Duration::rep>(random() >> (random() % 62 + 2)));
        estimate.echoed(now - Duration(static_cast<Duration::rep>(random() % 1'000'000'000)), now, peer);
        ASSERT_GE(estimate.uncertainty(now), Duration::zero());
        ASSERT_LE(std::abs(estimate.drift()), PeerClock::most_drift);
        (void)estimate.age(scene_start, now);
    }
}

}  // namespace
}  // namespace afferent
