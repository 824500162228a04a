#include "afferent/engine/coprocessor.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "afferent/engine/make_shard.hpp"
#include "afferent/engine/scan_routes.hpp"
#include "afferent/runtime/event_key.hpp"
#include "afferent/runtime/number_sorter.hpp"
#include "afferent/runtime/parallel.hpp"
#include "afferent/runtime/shard.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

// Several for a thread, so that busy skin is shared out.
constexpr std::size_t batches_per_thread = 4;

// Samples of a scan that are worth the threads' time.
constexpr std::size_t worth_sharing = 1 << 16;

// False: they are not all finite. Several sums, so that none waits for the one before: a number times 0 is 0,
// anything else NaN.
bool copy_finite(std::span<const double> forces_n, double* to) noexcept {
    std::array<double, 8> sums{};
    std::size_t i = 0;
    for (; i + sums.size() <= forces_n.size(); i += sums.size())
        for (std::size_t k = 0; k < sums.size(); ++k) {
            to[i + k] = forces_n[i + k];
            sums[k] += 0 * forces_n[i + k];
        }
    for (; i < forces_n.size(); ++i) {
        to[i] = forces_n[i];
        sums[0] += 0 * forces_n[i];
    }
    return std::accumulate(sums.begin(), sums.end(), 0.0) == 0;
}

}  // namespace

class Coprocessor::Impl {
  public:
    explicit Impl(const Plan& plan);

    void push(const Scan& scan);
    std::span<const Event> advance(TimePoint until);

    TimePoint now() const noexcept { return now_; }
    std::uint64_t late_scans() const noexcept { return late_scans_; }
    std::uint64_t refused_samples() const noexcept { return refused_samples_; }
    std::size_t waiting_samples() const noexcept { return waiting_; }
    std::size_t threads() const noexcept { return workers_.threads(); }
    std::size_t shards() const noexcept { return shards_.size(); }
    bool changes_forms() const noexcept { return changes_forms_; }
    std::size_t dense_shards() const noexcept;
    std::uint64_t form_changes() const noexcept;
    std::size_t bytes() const noexcept;
    void reset();

  private:
    // A shard with its scans.
    struct RoutedShard {
        std::unique_ptr<Shard> shard;
        std::vector<Scan> scans;  // of the window, for this shard
        TimePoint next;           // of the shard
    };
    // Neighbouring shards that are computed one after the other, with their events of the window.
    struct Batch {
        std::size_t begin;
        std::size_t end;
        EventKeys events;
        // Where there are slices: the events of each after those of the one before, and where they end.
        std::vector<EventKey> by_slice;
        std::vector<std::size_t> slice_ends;

        std::span<const EventKey> slice(std::size_t s) const noexcept {
            const std::size_t first = s == 0 ? 0 : slice_ends[s - 1];
            return std::span(by_slice).subspan(first, slice_ends[s] - first);
        }
    };
    // A part of the window. Its events of all batches are sorted by themselves.
    struct Slice {
        NumberSorter sorter;
        std::size_t first_event;  // among those of the window
    };

    // A window that is not too long for EventKeys.
    void advance_window(TimePoint until);
    bool append(std::span<const double> forces_n);
    void route_scans(TimePoint until);
    void compute(Batch& batch, TimePoint until);
    void divide(Batch& batch, TimePoint until) const;
    void sort_events();
    // Sorts the keys and stores their events in events_, from first_event on.
    void put_sorted(std::span<EventKey> keys, const NumberSorter& sorter, std::size_t first_event);

    std::uint32_t elements_;
    bool changes_forms_;
    std::vector<RoutedShard> shards_;
    std::vector<Batch> batches_;
    std::vector<Slice> slices_;   // as many as batches
    std::vector<EventKey> keys_;  // of all slices, where there are several
    ScanRoutes routes_;
    Workers workers_;
    std::vector<Scan> scans_;
    std::vector<double> forces_n_;       // of scans_, one after the other; and room for more
    std::size_t waiting_ = 0;            // of forces_n_
    std::vector<std::uint32_t> routed_;  // parts that have scans
    std::vector<Event> events_;          // the first event_count_ are of this call; the others have been
    std::size_t event_count_ = 0;
    TimePoint now_ = scene_start;
    std::uint64_t late_scans_ = 0;
    std::uint64_t refused_samples_ = 0;
};

Coprocessor::Impl::Impl(const Plan& plan)
    : elements_(plan.elements),
      changes_forms_(
          std::any_of(plan.patches.begin(), plan.patches.end(),
                      [](const PatchPlan& patch) { return patch.form == scene::Form::automatic; })),
      routes_(plan),
      workers_(plan.threads) {
    const std::size_t shards = plan.shards.size();
    const std::size_t batches =
        plan.threads > 1
            ? std::clamp<std::size_t>(batches_per_thread * plan.threads, 1, std::max<std::size_t>(1, shards))
            : 1;
    for (std::size_t i = 0; i < batches; ++i) {
        batches_.push_back({shards * i / batches, shards * (i + 1) / batches, {}, {}, {}});
        const std::span<const Plan::ShardPlan> planned =
            std::span(plan.shards).subspan(batches_[i].begin, batches_[i].end - batches_[i].begin);
        std::size_t afferents = 0;
        std::size_t swept = 0;
        for (const Plan::ShardPlan& shard : planned) {
            afferents += shard.count;
            if (plan.patches[shard.patch].form != scene::Form::sparse) swept += shard.count;
        }
        const std::shared_ptr<DenseScratch> scratch = swept > 0 ? make_dense_scratch(swept) : nullptr;
        for (const Plan::ShardPlan& shard : planned)
            shards_.push_back({make_shard(plan.patches[shard.patch], shard.begin, shard.count,
                                          plan.scene.runtime.spikes_per_window, scratch),
                               {},
                               scene_start});
        const std::size_t events = std::max<std::size_t>(2048, afferents / 4);
        batches_[i].events.keys().reserve(events);
        if (batches == 1) continue;
        batches_[i].by_slice.reserve(events);
        batches_[i].slice_ends.resize(batches);
    }
    slices_.resize(batches);
    // Usually there are two scans for each patch between two calls; when there are more, room grows once.
    scans_.reserve(4 * plan.patches.size());
    for (RoutedShard& routed : shards_) routed.scans.reserve(4);
    routed_.reserve(shards_.size());
    forces_n_.reserve(4 * std::size_t{plan.elements});
    events_.reserve(std::max<std::size_t>(2048, std::size_t{plan.addresses} / 4));
}

void Coprocessor::Impl::push(const Scan& scan) {
    const std::size_t room = scan.first < elements_ ? elements_ - scan.first : 0;
    const std::size_t count = std::min(scan.forces_n.size(), room);
    refused_samples_ += scan.forces_n.size() - count;
    if (scan.time < now_) ++late_scans_;
    const TimePoint time = std::max({scan.time, now_, scans_.empty() ? now_ : scans_.back().time});
    if (count == 0) return;
    // advance() turns what is noted here into spans, when the forces no longer move.
    const auto note = [&](std::size_t begin, std::size_t end) {
        scans_.push_back(
            {time, scan.first + static_cast<Address>(begin), scan.forces_n.subspan(begin, end - begin)});
    };
    if (append(scan.forces_n.first(count))) return note(0, count);
    // Taken back, and appended in the pieces between the samples that are not finite, whose elements keep
    // their last force.
    waiting_ -= count;
    for (std::size_t i = 0; i < count;) {
        std::size_t end = i;
        while (end < count && std::isfinite(scan.forces_n[end])) ++end;
        if (end > i) {
            append(scan.forces_n.subspan(i, end - i));
            note(i, end);
        }
        if (end < count) ++refused_samples_;
        i = end + 1;
    }
}

// Copies the forces behind those that wait, by all threads if they are many. False: they are not all finite.
bool Coprocessor::Impl::append(std::span<const double> forces_n) {
    if (forces_n_.size() < waiting_ + forces_n.size()) forces_n_.resize(waiting_ + forces_n.size());
    double* const to = forces_n_.data() + waiting_;
    waiting_ += forces_n.size();
    const auto copy = [&](std::size_t begin, std::size_t end) {
        return copy_finite(forces_n.subspan(begin, end - begin), to + begin);
    };
    const std::size_t parts = forces_n.size() < worth_sharing ? 1 : workers_.threads();
    if (parts == 1) return copy(0, forces_n.size());
    std::atomic<bool> finite = true;
    const auto copy_part = [&](std::size_t i) {
        if (!copy(forces_n.size() * i / parts, forces_n.size() * (i + 1) / parts)) finite = false;
    };
    workers_.run(parts, std::ref(copy_part));
    return finite;
}

std::span<const Event> Coprocessor::Impl::advance(TimePoint until) {
    event_count_ = 0;
    while (until - now_ >= EventKeys::longest) advance_window(now_ + EventKeys::longest / 2);
    advance_window(until);
    return std::span(events_).first(event_count_);
}

void Coprocessor::Impl::advance_window(TimePoint until) {
    route_scans(until);
    const auto compute_batch = [&](std::size_t i) { compute(batches_[i], until); };
    workers_.run(batches_.size(),
                 std::ref(compute_batch));  // a reference fits into std::function without memory
    std::size_t due = 0;
    std::size_t used = 0;
    for (; due < scans_.size() && scans_[due].time <= until; ++due) used += scans_[due].forces_n.size();
    scans_.erase(scans_.begin(), scans_.begin() + static_cast<std::ptrdiff_t>(due));
    std::move(forces_n_.begin() + static_cast<std::ptrdiff_t>(used),
              forces_n_.begin() + static_cast<std::ptrdiff_t>(waiting_), forces_n_.begin());
    waiting_ -= used;
    sort_events();
    now_ = std::max(now_, until);
}

// Gives each shard the scans that it may read.
void Coprocessor::Impl::route_scans(TimePoint until) {
    for (const std::uint32_t i : routed_) shards_[i].scans.clear();
    routed_.clear();
    std::size_t begin = 0;
    for (const Scan& waiting : scans_) {
        if (waiting.time > until) break;
        Scan scan = waiting;
        scan.forces_n = std::span(forces_n_).subspan(begin, waiting.forces_n.size());
        begin += scan.forces_n.size();
        routes_.for_each_reader(scan, [&](std::uint32_t i) {
            if (shards_[i].scans.empty()) routed_.push_back(i);
            shards_[i].scans.push_back(scan);
        });
    }
}

void Coprocessor::Impl::compute(Batch& batch, TimePoint until) {
    batch.events.begin(now_);
    for (std::size_t i = batch.begin; i < batch.end; ++i) {
        RoutedShard& routed = shards_[i];
        if (routed.scans.empty() && routed.next > until) continue;
        routed.shard->advance(until, routed.scans, batch.events);
        routed.next = routed.shard->next();
    }
    if (slices_.size() > 1) divide(batch, until);
}

// Slices are equally long parts of the window.
void Coprocessor::Impl::divide(Batch& batch, TimePoint until) const {
    const std::vector<EventKey>& keys = batch.events.keys();
    const double per_ns =
        static_cast<double>(slices_.size()) / (static_cast<double>((until - now_).count()) + 1);
    const auto slice_of = [&](EventKey key) {
        return static_cast<std::size_t>(static_cast<double>(key >> EventKeys::address_bits) * per_ns);
    };
    std::vector<std::size_t>& ends = batch.slice_ends;
    std::fill(ends.begin(), ends.end(), 0);
    for (const EventKey key : keys) ++ends[slice_of(key)];
    std::exclusive_scan(ends.begin(), ends.end(), ends.begin(), std::size_t{0});
    batch.by_slice.resize(keys.size());
    // Each event moves its slice's begin on, until it is its end.
    for (const EventKey key : keys) batch.by_slice[ends[slice_of(key)]++] = key;
}

// Appends the events of the window to events_, those of each slice by themselves.
void Coprocessor::Impl::sort_events() {
    const std::size_t before = event_count_;
    for (const Batch& batch : batches_) event_count_ += batch.events.keys().size();
    if (events_.size() < event_count_) events_.resize(std::max(event_count_, events_.capacity()));
    if (slices_.size() == 1)
        return put_sorted(batches_.front().events.keys(), slices_.front().sorter, before);
    if (keys_.size() < event_count_ - before) keys_.resize(events_.size() - before);
    std::size_t first = 0;
    for (std::size_t s = 0; s < slices_.size(); ++s) {
        slices_[s].first_event = first;
        for (const Batch& batch : batches_) first += batch.slice(s).size();
    }
    const auto sort_slice = [&](std::size_t s) {
        const std::size_t begin = slices_[s].first_event;
        std::size_t end = begin;
        for (const Batch& batch : batches_) {
            std::copy(batch.slice(s).begin(), batch.slice(s).end(),
                      keys_.begin() + static_cast<std::ptrdiff_t>(end));
            end += batch.slice(s).size();
        }
        put_sorted(std::span(keys_).subspan(begin, end - begin), slices_[s].sorter, before + begin);
    };
    workers_.run(slices_.size(), std::ref(sort_slice));
}

void Coprocessor::Impl::put_sorted(std::span<EventKey> keys, const NumberSorter& sorter,
                                   std::size_t first_event) {
    sorter.sort(keys);
    std::transform(keys.begin(), keys.end(), events_.begin() + static_cast<std::ptrdiff_t>(first_event),
                   [&](EventKey key) { return EventKeys::event(now_, key); });
}

std::size_t Coprocessor::Impl::dense_shards() const noexcept {
    return static_cast<std::size_t>(std::count_if(
        shards_.begin(), shards_.end(), [](const RoutedShard& routed) { return routed.shard->is_dense(); }));
}

std::uint64_t Coprocessor::Impl::form_changes() const noexcept {
    std::uint64_t sum = 0;
    for (const RoutedShard& routed : shards_) sum += routed.shard->form_changes();
    return sum;
}

std::size_t Coprocessor::Impl::bytes() const noexcept {
    std::size_t sum = 0;
    for (const RoutedShard& routed : shards_) sum += routed.shard->bytes();
    return sum;
}

void Coprocessor::Impl::reset() {
    for (RoutedShard& routed : shards_) {
        routed.shard->reset();
        routed.next = scene_start;
    }
    scans_.clear();
    waiting_ = 0;
    now_ = scene_start;
}

Coprocessor::Coprocessor(const Scene& scene) : Coprocessor(make_plan(scene)) {}
Coprocessor::Coprocessor(const Plan& plan) : impl_(std::make_unique<Impl>(plan)) {}
Coprocessor::~Coprocessor() = default;
Coprocessor::Coprocessor(Coprocessor&&) noexcept = default;
Coprocessor& Coprocessor::operator=(Coprocessor&&) noexcept = default;

void Coprocessor::push(const Scan& scan) { impl_->push(scan); }
std::span<const Event> Coprocessor::advance(TimePoint until) { return impl_->advance(until); }
TimePoint Coprocessor::now() const noexcept { return impl_->now(); }
std::uint64_t Coprocessor::late_scans() const noexcept { return impl_->late_scans(); }
std::uint64_t Coprocessor::refused_samples() const noexcept { return impl_->refused_samples(); }
std::size_t Coprocessor::waiting_samples() const noexcept { return impl_->waiting_samples(); }
std::size_t Coprocessor::threads() const noexcept { return impl_->threads(); }
std::size_t Coprocessor::shards() const noexcept { return impl_->shards(); }
bool Coprocessor::changes_forms() const noexcept { return impl_->changes_forms(); }
std::size_t Coprocessor::dense_shards() const noexcept { return impl_->dense_shards(); }
std::uint64_t Coprocessor::form_changes() const noexcept { return impl_->form_changes(); }
std::size_t Coprocessor::bytes() const noexcept { return impl_->bytes(); }
void Coprocessor::reset() { impl_->reset(); }

}  // namespace afferent
