#include "afferent/io/links/watchdog.hpp"

#include <algorithm>
#include <utility>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {

Watchdog::Watchdog(Duration freeze, Duration safe, MonotonicTime now)
    : freeze_(freeze), safe_(safe), last_heard_(now) {
    const double freeze_ms = Milliseconds(freeze).count();
    const double safe_ms = Milliseconds(safe).count();
    require(freeze_ms > 0, "freeze_ms", "> 0", freeze_ms);
    require(safe_ms > freeze_ms, "safe_ms", "> freeze_ms", safe_ms);
    silence_reason_ = "no packet for " + std::to_string(safe / 1ms) + " ms";
}

void Watchdog::heard(MonotonicTime now) noexcept {
    trip_on_silence(now);
    last_heard_ = std::max(last_heard_, now);
}

void Watchdog::trip(std::string reason) {
    if (tripped_) return;
    tripped_ = true;
    reason_ = std::move(reason);
}

GripState Watchdog::state(MonotonicTime now) noexcept {
    trip_on_silence(now);
    if (tripped_) return GripState::safe;
    return now - last_heard_ >= freeze_ ? GripState::frozen : GripState::operating;
}

void Watchdog::trip_on_silence(MonotonicTime now) noexcept {
    if (tripped_ || now - last_heard_ < safe_) return;
    tripped_ = true;
    reason_.swap(silence_reason_);
}

}  // namespace afferent
