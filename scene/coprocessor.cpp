#include "afferent/scene/coprocessor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "afferent/scene/make_shard.hpp"

namespace afferent {

Coprocessor::Coprocessor(const Plan& plan) : elements_(plan.elements), workers_(plan.threads) {
    for (const Plan::ShardPlan& shard : plan.shards) {
        parts_.push_back({make_shard(plan.patches[shard.patch], shard.begin, shard.count,
                                     plan.scene.runtime.spikes_per_window),
                          {}});
        parts_.back().events.reserve(std::max<std::size_t>(256, 2 * std::size_t{shard.count}));
    }
    merge_ = EventMerge(parts_.size());
    // Usually there are two scans for each patch between two calls; when there are more, room grows once.
    scans_.reserve(4 * plan.patches.size());
    forces_n_.reserve(4 * std::size_t{plan.elements});
    events_.reserve(std::max<std::size_t>(1024, 2 * std::size_t{plan.addresses}));
}

Coprocessor::~Coprocessor() = default;
Coprocessor::Coprocessor(Coprocessor&&) noexcept = default;
Coprocessor& Coprocessor::operator=(Coprocessor&&) noexcept = default;

void Coprocessor::push(const Scan& scan) {
    const std::size_t room = scan.first < elements_ ? elements_ - scan.first : 0;
    const std::size_t count = std::min(scan.forces_n.size(), room);
    refused_samples_ += scan.forces_n.size() - count;
    if (scan.time < now_) ++late_scans_;
    const TimePoint time = std::max({scan.time, now_, scans_.empty() ? now_ : scans_.back().time});
    for (std::size_t i = 0; i < count;) {
        // The scan is cut at a sample that is not finite: its element keeps its last force.
        std::size_t end = i;
        while (end < count && std::isfinite(scan.forces_n[end])) ++end;
        if (end > i) {
            // advance() turns these into spans, when the forces no longer move.
            scans_.push_back({time, scan.first + static_cast<Address>(i), scan.forces_n.subspan(i, end - i)});
            forces_n_.insert(forces_n_.end(), scan.forces_n.begin() + static_cast<std::ptrdiff_t>(i),
                             scan.forces_n.begin() + static_cast<std::ptrdiff_t>(end));
        }
        if (end < count) ++refused_samples_;
        i = end + 1;
    }
}

std::span<const Event> Coprocessor::advance(TimePoint until) {
    std::size_t begin = 0;
    std::size_t due = 0;
    for (Scan& scan : scans_) {
        scan.forces_n = std::span(forces_n_).subspan(begin, scan.forces_n.size());
        begin += scan.forces_n.size();
        if (scan.time <= until) ++due;
    }
    const std::span<const Scan> scans(scans_.data(), due);
    const auto advance_part = [&](std::size_t i) {
        parts_[i].events.clear();
        parts_[i].shard->advance(until, scans, parts_[i].events);
    };
    workers_.run(parts_.size(),
                 std::ref(advance_part));  // a reference fits into std::function without memory
    std::size_t used = 0;
    for (const Scan& scan : scans) used += scan.forces_n.size();
    scans_.erase(scans_.begin(), scans_.begin() + static_cast<std::ptrdiff_t>(due));
    forces_n_.erase(forces_n_.begin(), forces_n_.begin() + static_cast<std::ptrdiff_t>(used));
    now_ = std::max(now_, until);
    merge_events();
    return events_;
}

// Each part is sorted. Patches may be given in any order of time, so the parts interleave.
void Coprocessor::merge_events() {
    merge_([this](std::size_t i) { return std::span<const Event>(parts_[i].events); }, events_);
}

std::size_t Coprocessor::bytes() const noexcept {
    std::size_t sum = 0;
    for (const Part& part : parts_) sum += part.shard->bytes();
    return sum;
}

void Coprocessor::reset() {
    for (Part& part : parts_) part.shard->reset();
    scans_.clear();
    forces_n_.clear();
    now_ = scene_start;
}

}  // namespace afferent
