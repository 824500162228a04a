#include "afferent/engine/coprocessor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "afferent/engine/make_shard.hpp"

namespace afferent {

namespace {

// Several for a thread, so that busy skin is shared out.
constexpr std::size_t lots_per_thread = 4;

}  // namespace

Coprocessor::Coprocessor(const Plan& plan)
    : elements_(plan.elements),
      changes_forms_(
          std::any_of(plan.patches.begin(), plan.patches.end(),
                      [](const PatchPlan& patch) { return patch.form == scene::Form::automatic; })),
      routes_(plan),
      workers_(plan.threads) {
    const std::size_t shards = plan.shards.size();
    const std::size_t lots = plan.threads > 1 ? std::clamp<std::size_t>(lots_per_thread * plan.threads, 1,
                                                                        std::max<std::size_t>(1, shards))
                                              : 1;
    for (std::size_t i = 0; i < lots; ++i) {
        lots_.push_back({shards * i / lots, shards * (i + 1) / lots, {}, {}});
        std::shared_ptr<DenseScratch> scratch;
        std::size_t afferents = 0;
        for (std::size_t k = lots_[i].begin; k < lots_[i].end; ++k) {
            const Plan::ShardPlan& shard = plan.shards[k];
            const PatchPlan& patch = plan.patches[shard.patch];
            if (patch.form != scene::Form::sparse && !scratch) scratch = make_dense_scratch();
            parts_.push_back(
                {make_shard(patch, shard.begin, shard.count, plan.scene.runtime.spikes_per_window, scratch),
                 {},
                 scene_start});
            afferents += shard.count;
        }
        lots_[i].events.keys().reserve(std::max<std::size_t>(2048, afferents / 4));
    }
    if (lots > 1) slices_.assign(lots, {EventMerge(lots), 0});
    // Usually there are two scans for each patch between two calls; when there are more, room grows once.
    scans_.reserve(4 * plan.patches.size());
    for (Part& part : parts_) part.scans.reserve(4);
    routed_.reserve(parts_.size());
    forces_n_.reserve(4 * std::size_t{plan.elements});
    events_.reserve(std::max<std::size_t>(2048, std::size_t{plan.addresses} / 4));
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
    events_.clear();
    while (until - now_ >= EventKeys::longest) advance_window(now_ + EventKeys::longest / 2);
    advance_window(until);
    return events_;
}

void Coprocessor::advance_window(TimePoint until) {
    route_scans(until);
    const auto compute_lot = [&](std::size_t i) { compute(lots_[i], until); };
    workers_.run(lots_.size(), std::ref(compute_lot));  // a reference fits into std::function without memory
    std::size_t due = 0;
    std::size_t used = 0;
    for (; due < scans_.size() && scans_[due].time <= until; ++due) used += scans_[due].forces_n.size();
    scans_.erase(scans_.begin(), scans_.begin() + static_cast<std::ptrdiff_t>(due));
    forces_n_.erase(forces_n_.begin(), forces_n_.begin() + static_cast<std::ptrdiff_t>(used));
    merge_events(until);
    now_ = std::max(now_, until);
}

// Gives each shard the scans that it may read.
void Coprocessor::route_scans(TimePoint until) {
    for (const std::uint32_t i : routed_) parts_[i].scans.clear();
    routed_.clear();
    std::size_t begin = 0;
    for (const Scan& waiting : scans_) {
        if (waiting.time > until) break;
        Scan scan = waiting;
        scan.forces_n = std::span(forces_n_).subspan(begin, waiting.forces_n.size());
        begin += scan.forces_n.size();
        routes_.for_each_reader(scan, [&](std::uint32_t i) {
            if (parts_[i].scans.empty()) routed_.push_back(i);
            parts_[i].scans.push_back(scan);
        });
    }
}

void Coprocessor::compute(Lot& lot, TimePoint until) {
    lot.events.begin(now_);
    for (std::size_t i = lot.begin; i < lot.end; ++i) {
        Part& part = parts_[i];
        if (part.scans.empty() && part.next > until) continue;
        part.shard->advance(until, part.scans, lot.events);
        part.next = part.shard->next();
    }
    lot.sorter.sort(lot.events.keys());
}

// Appends the events of the window to events_. Those of several lots are merged in slices of time, which are
// independent of each other.
void Coprocessor::merge_events(TimePoint until) {
    std::size_t size = events_.size();
    if (slices_.empty()) {
        const std::vector<EventKey>& keys = lots_.front().events.keys();
        events_.resize(size + keys.size());
        for (const EventKey key : keys) events_[size++] = EventKeys::event(now_, key);
        return;
    }
    for (std::size_t s = 0; s < slices_.size(); ++s) {
        slices_[s].first_event = size;
        for (const Lot& lot : lots_) size += keys_in(lot, s, until).size();
    }
    events_.resize(size);
    const auto merge_slice = [&](std::size_t s) {
        Event* event = events_.data() + slices_[s].first_event;
        slices_[s].merge([&](std::size_t i) { return keys_in(lots_[i], s, until); },
                         [&](EventKey key) { *event++ = EventKeys::event(now_, key); });
    };
    workers_.run(slices_.size(), std::ref(merge_slice));
}

std::span<const EventKey> Coprocessor::keys_in(const Lot& lot, std::size_t slice, TimePoint until) const {
    const std::vector<EventKey>& keys = lot.events.keys();
    // The first event of a slice that begins that many parts of the window after its begin.
    const auto first = [&](std::size_t parts) {
        if (parts == slices_.size()) return keys.end();
        const auto begin =
            (until - now_) / static_cast<Duration::rep>(slices_.size()) * static_cast<Duration::rep>(parts);
        return std::lower_bound(keys.begin(), keys.end(),
                                static_cast<EventKey>(begin.count()) << EventKeys::address_bits);
    };
    return {first(slice), first(slice + 1)};
}

std::size_t Coprocessor::dense_shards() const noexcept {
    return static_cast<std::size_t>(
        std::count_if(parts_.begin(), parts_.end(), [](const Part& part) { return part.shard->is_dense(); }));
}

std::uint64_t Coprocessor::form_changes() const noexcept {
    std::uint64_t sum = 0;
    for (const Part& part : parts_) sum += part.shard->form_changes();
    return sum;
}

std::size_t Coprocessor::bytes() const noexcept {
    std::size_t sum = 0;
    for (const Part& part : parts_) sum += part.shard->bytes();
    return sum;
}

void Coprocessor::reset() {
    for (Part& part : parts_) {
        part.shard->reset();
        part.next = scene_start;
    }
    scans_.clear();
    forces_n_.clear();
    now_ = scene_start;
}

}  // namespace afferent
