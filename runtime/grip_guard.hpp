// The one rule by which a hand freezes, goes safe and operates again.
#pragma once

#include <string>

#include "afferent/runtime/grip_state.hpp"
#include "afferent/runtime/monotonic_time.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// Why the grip is not operating, and the figure that belongs to it: a silence, or the age of packets.
struct GripCause {
    enum class Kind {
        none,           // it is operating
        no_session,     // there has been no session yet
        silence,        // no packet has come
        stale_packets,  // packets have come, too old to be used
        no_samples,     // packets have come, and say that the sensors are silent
        session_ended,
        awaits_user,  // a new session is in order, and the user has not acknowledged it yet
    };
    Kind kind = Kind::none;
    Duration figure{};

    friend bool operator==(const GripCause&, const GripCause&) = default;
};

// In words: "no packet for 150 ms". Allocates: not for the hot path.
std::string text(const GripCause& cause);

// Silence is the time between two packets that came in time; nothing else that comes ends it.
//
//  - Silence for `freeze`, or the session's end, freezes an operating grip. In the same session the next
//    packet lets it operate again.
//  - Silence for `safe` makes it safe: by time alone, in whatever state. A session in which that happened is
//    spent: nothing that comes in it changes anything any more.
//  - A new session lets the grip operate once packets have kept arriving for as long as `freeze`, without a
//    pause as long as that: it takes two packets at least. With Rearm::by_user a safe grip then also waits
//    for the acknowledgement, which counts only from then on and while packets keep arriving. That a session
//    opens changes nothing by itself, and until it has proved itself its packets do not postpone the safe
//    state.
//
// Pure: it reads no clock and allocates nothing. The state follows from the times that it is told, so that
// asking late or not at all changes nothing. Times should not decrease; a packet whose arrival is told late
// counts from when it arrived, but revokes no state that has been given out.
// (docs/safe_state.md draws the states; tests/runtime/grip_guard_test.cpp walks every edge.)
class GripGuard {
  public:
    struct Limits {
        Duration freeze;
        Duration safe;
        Rearm rearm = Rearm::new_session;
    };

    // Safe: there has been no session. Throws ParameterError: freeze_ms > 0, safe_ms > freeze_ms.
    GripGuard(const Limits& limits, MonotonicTime now);
    // Operating, in a session that begins with it: for two sides in one process, which begin together.
    static GripGuard within_session(const Limits& limits, MonotonicTime now);

    // The handshake is done. Ends the session before it, if nobody has.
    void session_opened(MonotonicTime now) noexcept;
    void session_ended(MonotonicTime now) noexcept;
    // An authenticated packet of the session that measured something, in time.
    void heard(MonotonicTime now) noexcept;
    // One that was too old, or of unknown age (Duration::max()), or had no samples to tell of: no sign of
    // life, but the reason for the silence.
    void stale(MonotonicTime now, Duration age) noexcept;
    void without_samples(MonotonicTime now) noexcept;
    // The user has acknowledged that the hand may operate again.
    void acknowledged(MonotonicTime now) noexcept;

    GripState state(MonotonicTime now) noexcept;
    // Why the grip was in the state that was last asked for.
    const GripCause& cause() const noexcept { return cause_; }
    // Only a new session can re-arm the hand: the one that is there has made it safe.
    bool spent() const noexcept { return session_ == Session::spent; }

  private:
    enum class Session { none, fresh, trusted, spent };

    void settle(MonotonicTime now) noexcept;
    void enter(GripState state, Duration silence) noexcept;
    void measure_nothing(MonotonicTime now, const GripCause& why) noexcept;
    bool proved() const noexcept { return heard_ - steady_since_ >= limits_.freeze; }
    void trust() noexcept;

    Limits limits_;
    MonotonicTime latest_;  // the latest of all times told
    Session session_ = Session::none;
    GripState state_ = GripState::safe;
    GripCause cause_{GripCause::Kind::no_session};
    GripCause silence_{GripCause::Kind::silence};  // why, if it lasts
    MonotonicTime trusted_until_;  // the last packet heard in a trusted session: from here silence counts
    // In a fresh session: when it opened or a packet came last, and since when there has been no pause.
    MonotonicTime heard_;
    MonotonicTime steady_since_;
};

}  // namespace afferent
