#include "afferent/io/links/peer_clock.hpp"

#include <algorithm>
#include <cmath>

namespace afferent {
namespace {

Duration part(double rate, Duration of) {
    return Duration(std::llround(rate * static_cast<double>(of.count())));
}

}  // namespace

bool PeerClock::echoed(MonotonicTime sent, MonotonicTime received, TimePoint peer) noexcept {
    // The bounds include the drift of the two clocks during the round trip.
    const Duration round_trip = received - sent;
    const Duration slack = part(most_drift, round_trip) + Duration(1);
    const Duration at_receipt = (peer - scene_start) - received.time_since_epoch();
    const Bounds seen{at_receipt - slack, at_receipt + round_trip + slack};
    if (!known_) {
        start_over(seen, received);
    } else {
        const Bounds before = bounds(received);
        const Bounds both{std::max(before.low, seen.low), std::min(before.high, seen.high)};
        if (both.low <= both.high) {
            bounds_ = both;
            at_ = std::max(at_, received);
            refused_in_a_row_ = 0;
        } else {
            ++refused_;
            if (++refused_in_a_row_ <= most_refused_in_a_row) return false;
            start_over(seen, received);
        }
    }
    shortest_[0] = std::min(shortest_[0], round_trip);
    if (received >= block_end_) follow_drift(received);
    return true;
}

void PeerClock::start_over(const Bounds& seen, MonotonicTime now) noexcept {
    known_ = true;
    bounds_ = seen;
    at_ = now;
    drift_ = 0;
    anchors_count_ = 0;
    block_end_ = now + block;
    refused_in_a_row_ = 0;
    shortest_.fill(Duration::max());
}

// Once for each block.
void PeerClock::follow_drift(MonotonicTime now) noexcept {
    const Duration offset = bounds_.middle();
    if (anchors_count_ > 0) {
        const Anchor& oldest =
            anchors_[anchors_count_ < anchors_.size() ? 0 : anchors_count_ % anchors_.size()];
        const double rate = static_cast<double>((offset - oldest.offset).count()) /
                            static_cast<double>((now - oldest.time).count());
        drift_ = std::clamp(rate, -most_drift, most_drift);
    }
    anchors_[anchors_count_++ % anchors_.size()] = {now, offset};
    shortest_ = {Duration::max(), shortest_[0]};
    block_end_ = now + block;
}

// The bounds move by the known drift, and widen by its uncertainty.
PeerClock::Bounds PeerClock::bounds(MonotonicTime now) const noexcept {
    const Duration since = std::max<Duration>(now - at_, Duration::zero());
    const Duration moved = part(drift_, since);
    const Duration slack = part(drift_is_known() ? most_wander : most_drift, since);
    return {bounds_.low + moved - slack, bounds_.high + moved + slack};
}

TimePoint PeerClock::time(MonotonicTime now) const noexcept {
    return scene_start + Duration(now.time_since_epoch()) + bounds(now).middle();
}

Duration PeerClock::uncertainty(MonotonicTime now) const noexcept {
    const Bounds both = bounds(now);
    return (both.high - both.low) / 2;
}

}  // namespace afferent
