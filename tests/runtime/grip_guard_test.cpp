#include "afferent/runtime/grip_guard.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <random>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

using Kind = GripCause::Kind;

constexpr MonotonicTime start{};
constexpr GripGuard::Limits by_session{.freeze = 60ms, .safe = 150ms};
constexpr GripGuard::Limits by_user{.freeze = 60ms, .safe = 150ms, .rearm = Rearm::by_user};

constexpr MonotonicTime at(Duration since_start) { return start + since_start; }

// Packets every 20 ms, both ends included.
void hear(GripGuard& guard, Duration from, Duration to) {
    for (Duration t = from; t <= to; t += 20ms) guard.heard(at(t));
}

// Operating since 60 ms; the last packet came at 100 ms.
GripGuard operating(const GripGuard::Limits& limits = by_session) {
    GripGuard guard(limits, start);
    guard.session_opened(start);
    hear(guard, 0ms, 60ms);
    guard.acknowledged(at(60ms));
    hear(guard, 80ms, 100ms);
    EXPECT_EQ(guard.state(at(100ms)), GripState::operating);
    return guard;
}

TEST(GripGuard, BeginsSafeAndTimeAloneDoesNotChangeThat) {
    GripGuard guard(by_session, start);
    EXPECT_EQ(guard.state(start), GripState::safe);
    EXPECT_EQ(guard.state(at(1h)), GripState::safe);
    EXPECT_EQ(guard.cause(), GripCause{Kind::no_session});
    EXPECT_FALSE(guard.spent());
}

TEST(GripGuard, IsNotChangedByASessionThatOpens) {
    GripGuard guard(by_session, start);
    guard.session_opened(start);
    EXPECT_EQ(guard.state(start), GripState::safe);
    EXPECT_EQ(guard.state(at(1h)), GripState::safe);
    EXPECT_FALSE(guard.spent()) << "its packets are still to come";
    GripGuard running = operating();
    running.session_opened(at(101ms));
    EXPECT_EQ(running.state(at(101ms)), GripState::frozen) << "the session before it has ended";
}

TEST(GripGuard, OperatesOncePacketsOfASessionHaveKeptArrivingForAsLongAsTheFirstThreshold) {
    GripGuard guard(by_session, start);
    guard.session_opened(start);
    for (const Duration t : {500'000us, 520'000us, 540'000us, 559'999us}) {
        guard.heard(at(t));
        EXPECT_EQ(guard.state(at(t)), GripState::safe);
    }
    guard.heard(at(560ms));
    EXPECT_EQ(guard.state(at(560ms)), GripState::operating);
    EXPECT_EQ(guard.cause(), GripCause{});
}

TEST(GripGuard, CountsFromTheOpeningOfASessionWhosePacketsFollowAtOnce) {
    GripGuard guard(by_session, start);
    guard.session_opened(start);
    guard.heard(at(25ms));
    guard.heard(at(50ms));
    EXPECT_EQ(guard.state(at(50ms)), GripState::safe);
    guard.heard(at(75ms));
    EXPECT_EQ(guard.state(at(75ms)), GripState::operating);
}

TEST(GripGuard, TakesOnePacketForNoProof) {
    GripGuard guard(by_session, start);
    guard.session_opened(start);
    for (Duration t = 59ms; t < 10s; t += 60ms) guard.heard(at(t));
    EXPECT_EQ(guard.state(at(10s)), GripState::safe);
}

TEST(GripGuard, StartsTheProofOverAfterAPause) {
    GripGuard guard(by_session, start);
    guard.session_opened(start);
    hear(guard, 0ms, 40ms);
    hear(guard, 100ms, 140ms);  // a pause of 60 ms
    EXPECT_EQ(guard.state(at(140ms)), GripState::safe);
    guard.heard(at(160ms));
    EXPECT_EQ(guard.state(at(160ms)), GripState::operating);
}

TEST(GripGuard, DoesNotTakePacketsWithoutASessionForASign) {
    GripGuard guard(by_session, start);
    hear(guard, 0ms, 1s);
    EXPECT_EQ(guard.state(at(1s)), GripState::safe);
    GripGuard left = operating();
    left.session_ended(at(100ms));
    hear(left, 100ms, 1s);
    EXPECT_EQ(left.state(at(1s)), GripState::safe);
}

TEST(GripGuard, FreezesAtTheFirstThresholdAndThawsWithTheNextPacket) {
    GripGuard guard = operating();
    EXPECT_EQ(guard.state(at(160ms - 1ns)), GripState::operating);
    EXPECT_EQ(guard.state(at(160ms)), GripState::frozen);
    EXPECT_EQ(guard.cause(), (GripCause{Kind::silence, 60ms}));
    guard.heard(at(240ms));
    EXPECT_EQ(guard.state(at(240ms)), GripState::operating);
    EXPECT_EQ(guard.state(at(300ms)), GripState::frozen);
}

TEST(GripGuard, IsSafeFromTheSecondThresholdOnAndTheSessionIsSpent) {
    GripGuard guard = operating();
    EXPECT_EQ(guard.state(at(250ms - 1ns)), GripState::frozen);
    EXPECT_EQ(guard.state(at(250ms)), GripState::safe);
    EXPECT_EQ(guard.cause(), (GripCause{Kind::silence, 150ms}));
    EXPECT_TRUE(guard.spent());
    hear(guard, 260ms, 2s);
    guard.acknowledged(at(2s));
    EXPECT_EQ(guard.state(at(2s)), GripState::safe);
}

TEST(GripGuard, IsSafeEvenIfNobodyAskedDuringTheSilence) {
    GripGuard guard = operating();
    hear(guard, 10s, 11s);
    EXPECT_EQ(guard.state(at(11s)), GripState::safe);
    EXPECT_EQ(guard.cause(), (GripCause{Kind::silence, 150ms}));
}

TEST(GripGuard, ReArmsAfterASpentSessionWithANewOne) {
    GripGuard guard = operating();
    EXPECT_EQ(guard.state(at(300ms)), GripState::safe);
    guard.session_ended(at(310ms));
    EXPECT_EQ(guard.state(at(310ms)), GripState::safe);
    guard.session_opened(at(320ms));
    EXPECT_FALSE(guard.spent());
    hear(guard, 320ms, 360ms);
    EXPECT_EQ(guard.state(at(360ms)), GripState::safe);
    guard.heard(at(380ms));
    EXPECT_EQ(guard.state(at(380ms)), GripState::operating);
}

TEST(GripGuard, FreezesAtTheEndOfASessionAndGoesSafeByTime) {
    GripGuard guard = operating();
    guard.session_ended(at(101ms));
    EXPECT_EQ(guard.state(at(101ms)), GripState::frozen);
    EXPECT_EQ(text(guard.cause()), "the session has ended");
    EXPECT_EQ(guard.state(at(250ms)), GripState::safe) << "counted from the last packet";
    EXPECT_EQ(text(guard.cause()), "no packet for 150 ms: the session has ended");
}

TEST(GripGuard, ThawsWithANewSessionByTheSameProofIfThatComesBeforeTheSafeState) {
    GripGuard guard = operating();
    guard.session_ended(at(101ms));
    guard.session_opened(at(110ms));
    hear(guard, 120ms, 160ms);
    EXPECT_EQ(guard.state(at(179ms)), GripState::frozen);
    guard.heard(at(180ms));
    EXPECT_EQ(guard.state(at(180ms)), GripState::operating);
}

TEST(GripGuard, IsNotKeptFromTheSafeStateByASessionThatHasProvedNothing) {
    GripGuard guard = operating();
    guard.session_ended(at(101ms));
    guard.session_opened(at(110ms));
    hear(guard, 200ms, 240ms);
    EXPECT_EQ(guard.state(at(249ms)), GripState::frozen);
    EXPECT_EQ(guard.state(at(250ms)), GripState::safe);
    EXPECT_FALSE(guard.spent());
    guard.heard(at(260ms));
    EXPECT_EQ(guard.state(at(260ms)), GripState::operating) << "the new session goes on proving itself";
}

TEST(GripGuard, TakesASessionThatOpensForTheEndOfTheOneBefore) {
    GripGuard guard = operating();
    guard.session_opened(at(105ms));
    guard.heard(at(106ms));
    EXPECT_EQ(guard.state(at(106ms)), GripState::frozen);
}

TEST(GripGuard, IsNotChangedByTheEndOfWhatWasNoSession) {
    GripGuard guard(by_session, start);
    guard.session_ended(at(1ms));
    guard.session_ended(at(2ms));
    EXPECT_EQ(guard.state(at(2ms)), GripState::safe);
    EXPECT_EQ(guard.cause(), GripCause{Kind::no_session});
}

TEST(GripGuard, TakesNoPacketThatMeasuredNothingForASignOfLife) {
    GripGuard guard = operating();
    for (Duration t = 120ms; t < 160ms; t += 20ms) guard.stale(at(t), 118ms);
    EXPECT_EQ(guard.state(at(160ms)), GripState::frozen);
    EXPECT_EQ(text(guard.cause()), "packets are 118 ms old when they arrive");
    guard.without_samples(at(170ms));
    EXPECT_EQ(guard.state(at(170ms)), GripState::frozen);
    EXPECT_EQ(guard.cause(), (GripCause{Kind::stale_packets, 118ms})) << "that is why it froze";
    EXPECT_EQ(guard.state(at(250ms)), GripState::safe);
    EXPECT_EQ(text(guard.cause()), "no samples from the sensors for 150 ms");
}

TEST(GripGuard, SaysWhatKeepsANewSessionFromBeingTrusted) {
    GripGuard guard(by_session, start);
    guard.session_opened(start);
    guard.stale(at(20ms), 115ms);
    EXPECT_EQ(guard.state(at(20ms)), GripState::safe);
    EXPECT_EQ(guard.cause(), (GripCause{Kind::stale_packets, 115ms}));
    guard.stale(at(30ms), Duration::max());
    EXPECT_EQ(text(guard.cause()), "packets arrive, and how old they are is not known");
    guard.without_samples(at(40ms));
    EXPECT_EQ(text(guard.cause()), "no samples from the sensors");
}

TEST(GripGuard, SaysOfASessionThatIsNotToBeTrustedWhatItSaidBefore) {
    GripGuard spent = operating();
    EXPECT_EQ(spent.state(at(250ms)), GripState::safe);
    spent.stale(at(260ms), 115ms);
    EXPECT_EQ(spent.cause(), (GripCause{Kind::silence, 150ms}));
    GripGuard frozen = operating();
    frozen.session_ended(at(101ms));
    frozen.session_opened(at(110ms));
    frozen.stale(at(120ms), 115ms);
    EXPECT_EQ(frozen.state(at(120ms)), GripState::frozen);
    EXPECT_EQ(frozen.cause(), GripCause{Kind::session_ended});
    GripGuard waits(by_user, start);
    waits.session_opened(start);
    hear(waits, 0ms, 60ms);
    waits.stale(at(70ms), 115ms);
    EXPECT_EQ(waits.cause(), GripCause{Kind::awaits_user});
    waits.acknowledged(at(80ms));
    EXPECT_EQ(waits.state(at(80ms)), GripState::operating);
}

// They were held up; the session has been silent for too long by the time that they are told.
TEST(GripGuard, HasSpentASessionWhosePacketsAreToldTooLate) {
    GripGuard guard(by_session, start);
    guard.session_opened(start);
    EXPECT_EQ(guard.state(at(500ms)), GripState::safe);
    hear(guard, 0ms, 60ms);
    EXPECT_TRUE(guard.spent());
    EXPECT_EQ(guard.cause(), (GripCause{Kind::silence, 150ms}));
    EXPECT_EQ(guard.state(at(500ms)), GripState::safe);
}

TEST(GripGuard, CountsAPacketThatIsToldLateFromWhenItArrived) {
    GripGuard guard = operating();
    EXPECT_EQ(guard.state(at(170ms)), GripState::frozen);
    guard.heard(at(105ms));
    EXPECT_EQ(guard.state(at(170ms)), GripState::frozen);
    guard.heard(at(165ms));
    EXPECT_EQ(guard.state(at(170ms)), GripState::operating);
    EXPECT_EQ(guard.state(at(315ms)), GripState::safe);
    guard.heard(at(300ms));
    EXPECT_EQ(guard.state(at(315ms)), GripState::safe) << "a state that was given out is not revoked";
}

TEST(GripGuard, WaitsForItsUserWhereTheSceneWantsThat) {
    GripGuard guard(by_user, start);
    guard.session_opened(start);
    guard.acknowledged(at(10ms));  // too early: nothing is in order yet
    hear(guard, 20ms, 200ms);
    EXPECT_EQ(guard.state(at(200ms)), GripState::safe);
    EXPECT_EQ(guard.cause(), GripCause{Kind::awaits_user});
    guard.acknowledged(at(210ms));
    EXPECT_EQ(guard.state(at(210ms)), GripState::operating);
    // A frozen grip is not safe: it needs no acknowledgement.
    EXPECT_EQ(guard.state(at(260ms)), GripState::frozen);
    guard.heard(at(270ms));
    EXPECT_EQ(guard.state(at(270ms)), GripState::operating);
}

TEST(GripGuard, NeedsNoAcknowledgementForANewSessionBeforeTheSafeState) {
    GripGuard guard = operating(by_user);
    guard.session_ended(at(101ms));
    guard.session_opened(at(110ms));
    hear(guard, 120ms, 180ms);
    EXPECT_EQ(guard.state(at(180ms)), GripState::operating);
}

TEST(GripGuard, TakesNoAcknowledgementAfterThePacketsHavePaused) {
    GripGuard guard(by_user, start);
    guard.session_opened(start);
    hear(guard, 0ms, 100ms);
    guard.acknowledged(at(160ms));
    EXPECT_EQ(guard.state(at(160ms)), GripState::safe);
    EXPECT_EQ(guard.cause(), (GripCause{Kind::silence, 60ms}));
    hear(guard, 180ms, 240ms);
    EXPECT_EQ(guard.state(at(240ms)), GripState::safe);
    EXPECT_EQ(guard.cause(), GripCause{Kind::awaits_user});
    guard.session_ended(at(250ms));
    EXPECT_EQ(guard.cause(), GripCause{Kind::session_ended});
    guard.acknowledged(at(250ms));
    EXPECT_EQ(guard.state(at(250ms)), GripState::safe);
}

TEST(GripGuard, DoesNotKeepAnAcknowledgementForTheNextTime) {
    GripGuard guard = operating(by_user);
    guard.acknowledged(at(110ms));
    EXPECT_EQ(guard.state(at(300ms)), GripState::safe);
    guard.acknowledged(at(310ms));
    guard.session_opened(at(320ms));
    hear(guard, 320ms, 400ms);
    EXPECT_EQ(guard.state(at(400ms)), GripState::safe);
    EXPECT_EQ(guard.cause(), GripCause{Kind::awaits_user});
}

TEST(GripGuard, BeginsOperatingWithinASessionOfOneProcess) {
    GripGuard guard = GripGuard::within_session(by_session, start);
    EXPECT_EQ(guard.state(at(60ms - 1ns)), GripState::operating);
    EXPECT_EQ(guard.state(at(60ms)), GripState::frozen);
    EXPECT_EQ(guard.state(at(150ms)), GripState::safe);
}

TEST(GripGuard, RefusesThresholdsInTheWrongOrder) {
    const auto refusal = [](const GripGuard::Limits& limits) -> std::string {
        try {
            GripGuard(limits, start);
        } catch (const ParameterError& error) {
            return error.what();
        }
        return "accepted";
    };
    EXPECT_EQ(refusal({.freeze = 0ms, .safe = 150ms}), "freeze_ms must be > 0, is 0");
    EXPECT_EQ(refusal({.freeze = 60ms, .safe = 60ms}), "safe_ms must be > freeze_ms, is 60");
    EXPECT_EQ(refusal({.freeze = 1ns, .safe = 2ns}), "accepted");
}

// The rule of the guard, stated by the packets that came and not by states: an observer keeps their history,
// and judges each answer by it.
class Observer {
  public:
    Observer(const GripGuard::Limits& limits) : limits_(limits), guard_(limits, start), unasked_(guard_) {}

    void fault(std::mt19937_64& random) {
        const auto any = [&](auto count) {
            return static_cast<Duration::rep>(random() % static_cast<std::uint64_t>(count));
        };
        // Mostly small steps, now and then a pause beyond each of the thresholds.
        constexpr Duration pauses[] = {1ms,  10ms, 25ms,  25ms,  25ms,  59ms,
                                       60ms, 61ms, 100ms, 149ms, 150ms, 3s};
        now_ += any(8) == 0 ? pauses[any(std::size(pauses))] : Duration(any(30'000'000));
        switch (any(40)) {
            case 0:
                both([&](GripGuard& guard) { guard.session_opened(now_); });
                end_session();
                open_ = true;
                first_ = last_ = now_;
                break;
            case 1:
                both([&](GripGuard& guard) { guard.session_ended(now_); });
                end_session();
                break;
            case 2:
                both([&](GripGuard& guard) { guard.stale(now_, 115ms); });
                break;
            case 3:
                both([&](GripGuard& guard) { guard.without_samples(now_); });
                break;
            case 4:
            case 5:
                both([&](GripGuard& guard) { guard.acknowledged(now_); });
                acknowledged_ = unbroken() && now_ - last_ < limits_.freeze;
                break;
            case 6:  // nothing but time
                break;
            default:
                both([&](GripGuard& guard) { guard.heard(now_); });
                hear();
        }
        judge();
    }

    void rearm() {
        guard_.session_opened(now_ += 1s);
        for (int i = 0; i <= 3; ++i) guard_.heard(now_ += 25ms);
        guard_.acknowledged(now_);
        ASSERT_EQ(guard_.state(now_), GripState::operating) << "a healthy session is not trusted";
    }

    std::uint64_t operating = 0;
    std::uint64_t frozen = 0;
    std::uint64_t safe = 0;

  private:
    template <class Act>
    void both(const Act& act) {
        act(guard_);
        act(unasked_);
    }

    void end_session() { open_ = used_ = acknowledged_ = false; }

    void hear() {
        if (!open_) return;
        if (now_ - last_ >= limits_.freeze) first_ = now_;
        last_ = now_;
        ever_ = now_;
    }

    // The packets of the session that is there have come without a pause for long enough.
    bool unbroken() const { return open_ && last_ - first_ >= limits_.freeze; }

    void judge() {
        const GripState state = guard_.state(now_);
        GripGuard asked_now = unasked_;
        ASSERT_EQ(state, asked_now.state(now_)) << "it depends on who asked before";
        ASSERT_EQ(guard_.cause(), asked_now.cause());
        ASSERT_EQ(guard_.cause() == GripCause{}, state == GripState::operating);
        if (!ever_ || now_ - *ever_ >= limits_.safe) {
            ASSERT_EQ(state, GripState::safe) << "nothing was heard";
        }
        if (state == GripState::operating) {
            ++operating;
            ASSERT_TRUE(open_) << "without a session";
            ASSERT_LT(now_ - last_, limits_.freeze) << "in silence";
            if (before_ != GripState::operating && !used_) {
                ASSERT_TRUE(unbroken()) << "by a session that has proved nothing";
            }
            if (before_ == GripState::safe) {
                ASSERT_FALSE(used_) << "by a session that had made it safe";
                if (limits_.rearm == Rearm::by_user) {
                    ASSERT_TRUE(acknowledged_) << "unasked";
                }
            }
            used_ = true;
        }
        if (state == GripState::frozen) {
            ++frozen;
            ASSERT_NE(before_, GripState::safe);
        }
        if (state == GripState::safe) ++safe;
        if (guard_.spent()) {
            ASSERT_TRUE(used_ && state == GripState::safe);
        }
        acknowledged_ = false;
        before_ = state;
    }

    GripGuard::Limits limits_;
    GripGuard guard_;
    GripGuard unasked_;  // gets the same calls, but is never asked for its state
    MonotonicTime now_ = start;
    GripState before_ = GripState::safe;
    bool open_ = false;
    bool used_ = false;  // the hand has operated in this session
    bool acknowledged_ = false;
    MonotonicTime first_{};  // since when this session has had no pause
    MonotonicTime last_{};   // it opened, or a packet came
    std::optional<MonotonicTime> ever_;
};

TEST(GripGuard, KeepsItsRuleThroughAMillionRandomFaults) {
    std::mt19937_64 random(1);
    for (const GripGuard::Limits& used : {by_session, by_user}) {
        Observer observer(used);
        for (int i = 0; i < 500'000 && !testing::Test::HasFatalFailure(); ++i) {
            observer.fault(random);
            if (i % 1000 != 0) continue;
            Observer copy = observer;
            copy.rearm();
        }
        // Every state is visited often.
        EXPECT_GT(observer.operating, 10'000U);
        EXPECT_GT(observer.frozen, 10'000U);
        EXPECT_GT(observer.safe, 10'000U);
    }
}

}  // namespace
}  // namespace afferent
