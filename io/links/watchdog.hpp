// Two thresholds of silence between a hand and its safe state.
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "afferent/runtime/grip_state.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// The hand's own clock, which no peer and no operator can set.
using MonotonicTime = std::chrono::steady_clock::time_point;
// Handed in, so that tests and virtual time can replace it.
using MonotonicClock = std::function<MonotonicTime()>;

// Silence past the first threshold freezes the grip: it must not close any further, and does again with the
// next packet. Past the second the hand goes to its safe state, and nothing but a new session ends that: a
// new hello makes a new watchdog. It is asked, not told: that an application asks late delays nothing but its
// own answer.
class Watchdog {
  public:
    // Throws ParameterError: freeze_ms > 0, safe_ms > freeze_ms.
    Watchdog(Duration freeze, Duration safe, MonotonicTime now);

    // A valid packet has come. Too late it changes nothing.
    void heard(MonotonicTime now) noexcept;

    // For another reason than silence.
    void trip(std::string reason);

    GripState state(MonotonicTime now) noexcept;

    // Why the state is safe; empty while it is not.
    const std::string& reason() const noexcept { return reason_; }

  private:
    void trip_on_silence(MonotonicTime now) noexcept;

    Duration freeze_;
    Duration safe_;
    MonotonicTime last_heard_;
    bool tripped_ = false;
    std::string reason_;
    std::string silence_reason_;  // made at construction: nothing that can fail stands before the safe state
};

}  // namespace afferent
