// What both ends foresee is not sent. These are the spans after the last packet, as the hand presumes them.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "afferent/engine/force_decoders.hpp"
#include "afferent/runtime/event.hpp"

namespace afferent {

// Feeds presumed spans to a copy of the decoders. The decoders themselves observe packets only, so a packet
// that arrives later is decoded as if nothing had been presumed.
class PresumedSpans {
  public:
    // `told` has decoded what was told. Makes room for so many events; more allocate.
    PresumedSpans(const ForceDecoders& told, std::size_t room) : decoders_(told) { events_.reserve(room); }

    // These events, sorted, of the time after the last packet. They replace those before.
    void presume(TimePoint until, std::span<const Event> events) {
        forget();
        until_ = until;
        events_.assign(events.begin(), events.end());
    }
    void forget() noexcept {
        until_ = scene_start;
        taken_ = 0;
        is_copy_ = false;
    }
    TimePoint until() const noexcept { return until_; }

    // The decoders as all before `until` has come as presumed, in packets of this length. `told` has not
    // changed since the last packet; `until` does not decrease.
    ForceDecoders& decoded(const ForceDecoders& told, TimePoint until, Duration packet) {
        if (!is_copy_) decoders_ = told;
        is_copy_ = true;
        for (TimePoint at = decoders_.heard_until(); at < until; at = decoders_.heard_until()) {
            const TimePoint end = std::min(at + packet, until);
            const std::size_t first = taken_;
            while (taken_ < events_.size() && events_[taken_].time < end) ++taken_;
            decoders_.observe(at, end, std::span(events_).subspan(first, taken_ - first));
        }
        return decoders_;
    }

    // What presume() was called with since the last packet.
    std::span<const Event> events() const noexcept { return events_; }
    std::size_t bytes() const {
        return sizeof *this + decoders_.heap_bytes() + events_.capacity() * sizeof(Event);
    }

  private:
    ForceDecoders decoders_;
    bool is_copy_ = false;  // of what was told, since the last packet
    TimePoint until_ = scene_start;
    std::vector<Event> events_;
    std::size_t taken_ = 0;  // of them, by the copy
};

}  // namespace afferent
