#include "afferent/studies/trial/sample_feedback.hpp"

#include <numeric>

namespace afferent {

double total_share(const Plan& plan) {
    double sum = 0;
    for (const PatchPlan& patch : plan.patches)
        if (patch.owns_elements) sum = std::accumulate(patch.share.begin(), patch.share.end(), sum);
    return sum;
}

SampleFeedback::SampleFeedback(const Plan& plan)
    : plan_(plan), shares_(total_share(plan)), gain_(*plan.controller), forces_n_(plan.elements) {}

void SampleFeedback::begin(std::uint32_t) {
    gain_.begin();
    forces_n_.assign(forces_n_.size(), 0);
    fresh_ = false;
    sent_at_ = newest_ = scene_start;
    waiting_.clear();
    estimate_ = {};
}

void SampleFeedback::sense(const Scan& scan) {
    std::copy(scan.forces_n.begin(), scan.forces_n.end(), forces_n_.begin() + scan.first);
    fresh_ = true;
}

void SampleFeedback::close(TimePoint deadline, Channel& channel) {
    if (!fresh_ && deadline - sent_at_ < plan_.timing.heartbeat) return;
    fresh_ = false;
    sent_at_ = deadline;
    proto::Samples& samples = *sent_.mutable_samples();
    samples.set_time_ns((deadline - scene_start).count());
    samples.mutable_force_n()->Assign(forces_n_.begin(), forces_n_.end());
    channel.send(deadline, frames_.datagram(sent_), 0);
}

bool SampleFeedback::arrive(std::span<const std::byte> frame, TimePoint arrived) {
    if (!read_datagram(frame, received_, counts_)) return false;
    const proto::Samples& samples = received_.samples();
    const TimePoint end = scene_start + Duration(samples.time_ns());
    // What has been overtaken, or is stale, is not used.
    const bool stale = plan_.timing.stale > Duration::zero() && arrived - end > plan_.timing.stale;
    if (stale || end <= newest_) return false;
    newest_ = end;
    const double force_n = std::accumulate(samples.force_n().begin(), samples.force_n().end(), 0.0) / shares_;
    waiting_.push_back({acts_at(plan_, end, arrived), force_n});
    return true;
}

std::optional<TimePoint> SampleFeedback::next_act() const {
    return waiting_.empty() ? std::nullopt : std::optional(waiting_.front().acts);
}

void SampleFeedback::act() {
    estimate_.force_n = waiting_.front().force_n;
    waiting_.pop_front();
}

}  // namespace afferent
