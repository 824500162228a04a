// The clock of tests that run both ends of a link in one loop.
#pragma once

#include <algorithm>

#include "afferent/runtime/monotonic_time.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// Follows the wall clock, but a turn of the loop takes at most `longest_turn` of it. So a process that is
// held up holds up its sessions and its scene as well, and only what a test makes late is late.
class TurnClock {
  public:
    explicit TurnClock(Duration most) : longest_turn(most) {}
    TurnClock(const TurnClock&) = delete;
    TurnClock& operator=(const TurnClock&) = delete;

    MonotonicTime now() const {
        return keeps_wall_time_ ? MonotonicTime::clock::now() + (now_ - wall_) : now_;
    }
    // For sessions; refers to this clock.
    MonotonicClock reader() const {
        return [this] { return now(); };
    }
    // From here on it follows the wall clock within a turn as well, however long that is.
    void keep_wall_time() { keeps_wall_time_ = true; }
    void turn() {
        if (keeps_wall_time_) return;
        const MonotonicTime wall = MonotonicTime::clock::now();
        now_ += std::min<Duration>(wall - wall_, longest_turn);
        wall_ = wall;
    }

    Duration longest_turn;

  private:
    MonotonicTime wall_ = MonotonicTime::clock::now();
    MonotonicTime now_ = wall_;
    bool keeps_wall_time_ = false;
};

}  // namespace afferent
