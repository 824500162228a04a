#include "afferent/studies/trial/send_on_delta.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "afferent/studies/trial/sample_feedback.hpp"

namespace afferent {
namespace {

PacketLayout with_two_addresses_per_element(const Plan& plan) {
    PacketLayout layout = packet_layout(plan);
    layout.addresses = 2 * plan.elements;
    // Changes are no spikes, which a neuron's law would foresee.
    if (layout.encoding == Encoding::predicted) {
        layout.encoding = Encoding::rice;
        layout.acknowledged = false;
    }
    return layout;
}

}  // namespace

SendOnDeltaFeedback::SendOnDeltaFeedback(const Plan& plan)
    : PacketFeedback(plan, with_two_addresses_per_element(plan)),
      parameters_(plan.scene.trial->send_on_delta),
      shares_(total_share(plan)),
      gain_(*plan.controller),
      sent_levels_(plan.elements),
      levels_(plan.elements) {}

void SendOnDeltaFeedback::begin(std::uint32_t presentation) {
    PacketFeedback::begin(presentation);
    gain_.begin();
    std::fill(sent_levels_.begin(), sent_levels_.end(), 0);
    std::fill(levels_.begin(), levels_.end(), 0);
    events_.clear();
    potential_ = 0;
    potential_at_ = scene_start;
    contact_ = false;
    estimate_ = {};
}

void SendOnDeltaFeedback::sense(const Scan& scan) {
    for (std::size_t i = 0; i < scan.forces_n.size(); ++i) {
        const Address element = scan.first + static_cast<Address>(i);
        std::int32_t& level = sent_levels_[element];
        const auto changes =
            static_cast<std::int32_t>(std::trunc(scan.forces_n[i] / parameters_.delta_n - level));
        level += changes;
        events_.insert(events_.end(), static_cast<std::size_t>(std::abs(changes)),
                       {scan.time, changes > 0 ? onset(element) : onset(element) + 1});
    }
}

std::span<const Event> SendOnDeltaFeedback::events_before(TimePoint deadline) {
    const auto later = std::find_if(events_.begin(), events_.end(),
                                    [deadline](const Event& event) { return event.time >= deadline; });
    given_.assign(events_.begin(), later);
    events_.erase(events_.begin(), later);
    return given_;
}

void SendOnDeltaFeedback::take(const Reception& reception) {
    for (const Event& event : reception.events) count(event);
    const auto level = std::accumulate(levels_.begin(), levels_.end(), std::int64_t{0});
    if (level <= 0) contact_ = false;
    estimate_.force_n = contact_ ? parameters_.delta_n * static_cast<double>(level) / shares_ : 0;
}

void SendOnDeltaFeedback::count(const Event& event) {
    const bool is_onset = event.address % 2 == 0;
    levels_[event.address / 2] += is_onset ? 1 : -1;
    if (!is_onset) return;
    const double passed_ms = Milliseconds(event.time - potential_at_).count();
    potential_ = potential_ * std::exp(-passed_ms / parameters_.time_constant_ms) + 1;
    potential_at_ = event.time;
    if (potential_ < parameters_.threshold_events) return;
    contact_ = true;
    potential_ = 0;
}

}  // namespace afferent
