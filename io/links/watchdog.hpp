// Freezes a hand after a short silence, and makes it safe after a long one.
#pragma once

#include <string>

#include "afferent/runtime/grip_state.hpp"
#include "afferent/runtime/monotonic_time.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// Silence beyond the first threshold freezes the grip: it must not close any further until the next packet.
// Beyond the second the hand goes to its safe state, which only a new session ends: a new hello makes a new
// watchdog. The state follows from the clock when it is asked for, so that asking late changes nothing.
class Watchdog {
  public:
    // Throws ParameterError: freeze_ms > 0, safe_ms > freeze_ms.
    Watchdog(Duration freeze, Duration safe, MonotonicTime now);

    // A valid packet has come. After the second threshold it changes nothing.
    void heard(MonotonicTime now) noexcept;

    // Makes the state safe for another reason than silence.
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
    std::string
        silence_reason_;  // made at construction, so that nothing can fail on the way to the safe state
};

}  // namespace afferent
