#include "afferent/nodes/ranks/load.hpp"

#include <algorithm>
#include <utility>

#include "afferent/nodes/ranks/messages.hpp"
#include "afferent/nodes/ranks/sorted_runs.hpp"
#include "afferent/nodes/ranks/stopwatch.hpp"
#include "afferent/nodes/run.hpp"

namespace afferent::ranks {
namespace {

// Enough to average over, and done in a fraction of a second.
constexpr std::size_t samples_after_first = 200'000;
constexpr int most_of_scene = 4;

// Puts a value in place for as long as it lives.
template <class T>
class Instead {
  public:
    Instead(T& place, T value) : place_(place), before_(std::exchange(place, std::move(value))) {}
    ~Instead() { place_ = std::move(before_); }
    Instead(const Instead&) = delete;
    Instead& operator=(const Instead&) = delete;

  private:
    T& place_;
    T before_;
};

using Shards = std::vector<Plan::ShardPlan>;

// In place of the neurons: their events. Those of other ranks are taken from messages and merged, as in a
// run.
class Prepared final : public EventExchange {
  public:
    explicit Prepared(EventsOfRanks events) : events_(std::move(events)), given_(events_.size()) {
        for (std::vector<Event>& of_rank : events_) std::sort(of_rank.begin(), of_rank.end());
    }
    void push(const Scan&) override {}
    void begin(TimePoint) override {}
    Result<std::span<const Event>> exchange(TimePoint until, std::span<const Event>) override {
        merged_.clear();
        for (std::size_t rank = 0; rank < events_.size(); ++rank) {
            const auto left = std::span<const Event>(events_[rank]).subspan(given_[rank]);
            const auto end = std::partition_point(left.begin(), left.end(),
                                                  [&](const Event& e) { return e.time <= until; });
            const std::span<const Event> window(left.begin(), end);
            given_[rank] += window.size();
            if (rank == 0) {
                merged_.add(window);
                continue;
            }
            message_.clear();
            put_events(message_, until_, until, window);
            taken_.clear();
            take_events(message_, taken_);
            merged_.add(taken_);
        }
        until_ = until;
        return merged_.merged();
    }

  private:
    EventsOfRanks events_;
    std::vector<std::size_t> given_;
    SortedRuns merged_;
    Bytes message_;
    std::vector<Event> taken_;
    TimePoint until_ = scene_start - Duration(1);
};

// The patch with elements of its own that has this element.
std::size_t owner_of(const Plan& plan, Address element) {
    for (std::size_t i = 0; i < plan.patches.size(); ++i) {
        const PatchPlan& patch = plan.patches[i];
        // One that reads its elements comes after it.
        if (element >= patch.first_element && element < patch.first_element + patch.elements()) return i;
    }
    return 0;
}

}  // namespace

bool is_known_before(const Plan& plan) {
    return plan.samples_from == SamplesFrom::coprocessor && !traits_of(plan.scene.source).once;
}

Result<Beginning> beginning_of(Plan& plan) {
    const Instead<Shards> no_neurons(plan.shards, {});
    AFFERENT_TRY(link_end, CoprocessorEnd::open(plan));
    Beginning beginning{};
    Observer output;
    output.scan = [&](const Scan& scan) {
        beginning.scans.push_back(
            {scan.time, scan.first, static_cast<std::uint32_t>(scan.forces_n.size()), beginning.ends.size()});
        beginning.forces_n.insert(beginning.forces_n.end(), scan.forces_n.begin(), scan.forces_n.end());
    };
    const TimePoint latest = scene_start + (plan.end() - scene_start) / most_of_scene;
    double began_s = 0;
    std::size_t in_first = 0;
    // It ends with a window.
    const auto is_enough = [&] {
        return beginning.end() + plan.timing.span > latest ||
               beginning.forces_n.size() >= in_first + samples_after_first;
    };
    for (;;) {
        const Due due = link_end->next();
        AFFERENT_TRY(link_end->do_next(output));
        if (due.kind == afferent::Kind::scan) continue;
        beginning.ends.push_back(due.time);
        if (beginning.ends.size() == 1) {
            in_first = beginning.forces_n.size();
            began_s = processor_s();
        }
        if (is_enough()) break;
    }
    beginning.sampling_s = processor_s() - began_s;
    return beginning;
}

ShardLoads measure(Plan& plan, std::span<const Plan::ShardPlan> shards, const Beginning& beginning) {
    const Instead<std::size_t> one_thread(plan.threads, 1);
    const Instead<Shards> one_shard(plan.shards, {});
    ShardLoads loads;
    for (const Plan::ShardPlan& shard : shards) {
        plan.shards.assign(1, shard);
        Coprocessor coprocessor(plan);
        double seconds = 0;
        auto scan = beginning.scans.begin();
        const double* forces_n = beginning.forces_n.data();
        for (std::size_t window = 0; window < beginning.ends.size(); ++window) {
            for (; scan != beginning.scans.end() && scan->window == window; ++scan) {
                coprocessor.push({scan->time, scan->first, {forces_n, scan->count}});
                forces_n += scan->count;
            }
            const double before_s = processor_s();
            const auto events = coprocessor.advance(beginning.ends[window] - Duration(1));
            if (window > 0) seconds += processor_s() - before_s;
            loads.events.insert(loads.events.end(), events.begin(), events.end());
        }
        loads.seconds.push_back(seconds);
    }
    return loads;
}

std::vector<double> with_sampling(std::vector<double> loads, const Plan& plan, const Beginning& beginning) {
    std::vector<double> samples(plan.patches.size());
    for (const Beginning::Sampled& scan : beginning.scans) samples[owner_of(plan, scan.first)] += scan.count;
    std::vector<double> readers(plan.patches.size());
    for (const PatchPlan& patch : plan.patches) readers[patch.reads] += patch.afferents();
    const double all = static_cast<double>(std::max<std::size_t>(1, beginning.forces_n.size()));
    for (std::size_t i = 0; i < loads.size(); ++i) {
        const std::size_t owner = plan.patches[plan.shards[i].patch].reads;
        loads[i] += beginning.sampling_s * samples[owner] / all * plan.shards[i].count / readers[owner];
    }
    return loads;
}

Result<double> rest_of_run(Plan& plan, const Beginning& beginning, EventsOfRanks events) {
    const Instead<Shards> no_neurons(plan.shards, {});
    const Instead<std::vector<scene::Output>> no_output(plan.scene.output, {});
    Prepared prepared(std::move(events));
    AFFERENT_TRY(run, Run::open(plan, {}, {}, &prepared));
    double began_s = 0;
    while (run->next() <= beginning.end()) {
        const bool first = run->next() <= beginning.ends.front();
        AFFERENT_TRY(run->do_next());
        if (first) began_s = processor_s();
    }
    return processor_s() - began_s;
}

}  // namespace afferent::ranks
