// Estimates what the peer's clock shows. Nothing but the messages between two clocks tells how far they are
// apart.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "afferent/runtime/monotonic_time.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// Each echo bounds the peer's clock from both sides: it was read after we asked and before we got the answer.
// The bounds of all echoes are intersected, and widen with time by as much as two clocks may drift. So the
// fastest recent round trips decide, echoes that were held up in one direction do no harm, and the
// uncertainty is known: at most half of a round trip, as long as echoes come. The estimate is the middle of
// the bounds, as if both ways took equally long.
//
// Memory and work are the same for every echo. The peer's clock is scene time.
class PeerClock {
  public:
    // Parts of a second per second. Quartz stays below a twentieth of it.
    static constexpr double most_drift = 2000e-6;
    // How far the drift may be from the one that is known.
    static constexpr double most_wander = 500e-6;

    // The peer's clock showed `peer` at some time between `sent` and `received`. False: that contradicts the
    // echoes before, and the echo is not used. After too many of these in a row the bounds are taken to be
    // wrong, and begin again.
    bool echoed(MonotonicTime sent, MonotonicTime received, TimePoint peer) noexcept;

    // Whether there has been an echo. Until then nothing else may be asked.
    bool known() const noexcept { return known_; }
    TimePoint time(MonotonicTime now) const noexcept;
    // How long ago the peer's clock showed this; negative if it has not yet.
    Duration age(TimePoint shown, MonotonicTime now) const noexcept { return time(now) - shown; }
    // How far time() and age() may be off.
    Duration uncertainty(MonotonicTime now) const noexcept;
    // The shortest of the last 8 to 16 seconds.
    Duration round_trip() const noexcept { return std::min(shortest_[0], shortest_[1]); }
    // The rate of the peer's clock less ours, in parts of a second per second; over up to two minutes. Zero
    // until it is known.
    double drift() const noexcept { return drift_; }
    std::uint64_t refused() const noexcept { return refused_; }

  private:
    static constexpr Duration block = 8s;
    static constexpr int most_refused_in_a_row = 8;

    struct Bounds {
        Duration low;
        Duration high;

        Duration middle() const noexcept { return low + (high - low) / 2; }
    };
    struct Anchor {
        MonotonicTime time;
        Duration offset;
    };

    bool drift_is_known() const noexcept { return anchors_count_ > 1; }
    Bounds bounds(MonotonicTime now) const noexcept;
    void start_over(const Bounds& seen, MonotonicTime now) noexcept;
    void follow_drift(MonotonicTime now) noexcept;

    bool known_ = false;
    Bounds bounds_{};  // of the peer's clock less ours, at that time:
    MonotonicTime at_{};
    double drift_ = 0;
    std::array<Duration, 2> shortest_{Duration::max(), Duration::max()};  // of this block and the last
    // What was estimated at the ends of past blocks, a ring.
    std::array<Anchor, 16> anchors_{};
    std::size_t anchors_count_ = 0;
    MonotonicTime block_end_{};
    int refused_in_a_row_ = 0;
    std::uint64_t refused_ = 0;
};

}  // namespace afferent
