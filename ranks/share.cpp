#include "afferent/ranks/share.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <thread>

#include "afferent/ranks/load.hpp"
#include "afferent/ranks/partition.hpp"
#include "afferent/runtime/spike_storm.hpp"

namespace afferent::ranks {
namespace {

// Measuring the load of fewer afferents takes longer than is won.
constexpr std::uint32_t worth_measuring = 64;

template <class T>
std::string to_bytes(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

template <class T>
std::vector<T> from_bytes(const std::string& bytes) {
    std::vector<T> values(bytes.size() / sizeof(T));
    if (!values.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
}

// What each rank gives, one after the other.
template <class T>
std::vector<T> gather_all(World& world, const std::vector<T>& values) {
    std::vector<T> all;
    for (const std::string& bytes : world.gather(to_bytes(values))) {
        const std::vector<T> part = from_bytes<T>(bytes);
        all.insert(all.end(), part.begin(), part.end());
    }
    return all;
}

std::vector<double> counts_of(const Plan& plan) {
    std::vector<double> counts;
    for (const Plan::ShardPlan& shard : plan.shards) counts.push_back(shard.count);
    return counts;
}

// Shards that were idle in the stretch that was measured may be busy later: a thousandth goes by their
// counts.
std::vector<double> with_counts(std::vector<double> loads, const std::vector<double>& counts) {
    const double load = std::accumulate(loads.begin(), loads.end(), 0.0);
    const double count = std::accumulate(counts.begin(), counts.end(), 0.0);
    const double weight = (load > 0 ? 1e-3 * load : 1) / count;
    for (std::size_t i = 0; i < loads.size(); ++i) loads[i] += weight * counts[i];
    return loads;
}

std::vector<Plan::ShardPlan> range(const std::vector<Plan::ShardPlan>& shards,
                                   const std::vector<std::size_t>& boundaries, std::size_t rank) {
    const auto at = [&](std::size_t i) {
        return shards.begin() + static_cast<std::ptrdiff_t>(boundaries[i]);
    };
    return {at(rank), at(rank + 1)};
}

struct Cut {
    std::vector<std::size_t> boundaries;
    double measured_s = 0;
};

// Each rank measures the shards of a first cut, by counts, and rank 0 cuts again. Nothing where a rank could
// not: the run will meet with the same error, and say so.
std::optional<Cut> cut_by_load(World& world, Plan& plan) {
    const std::vector<double> counts = counts_of(plan);
    const std::vector<std::size_t> by_counts = cut(counts, world.size());
    const std::vector<Plan::ShardPlan> own = range(plan.shards, by_counts, world.rank());
    std::optional<Stretch> stretch;
    ShardLoads measured;
    try {
        if (Result<Stretch> beginning = beginning_of(plan)) stretch = std::move(beginning.value());
        if (stretch) measured = measure(plan, own, *stretch);
    } catch (const SpikeStormError&) {
        measured = {};
    }
    const std::vector<double> loads = gather_all(world, measured.seconds);
    std::vector<Event> events = gather_all(world, measured.events);
    std::vector<std::size_t> boundaries;
    if (stretch && loads.size() == plan.shards.size())
        if (const Result<double> rest_s = rest_of_run(plan, *stretch, std::move(events)))
            boundaries = cut(with_counts(loads, counts), world.size(),
                             std::max(0.0, rest_s.value() - stretch->sampling_s));
    boundaries = from_bytes<std::size_t>(world.broadcast(to_bytes(boundaries)));
    if (boundaries.empty()) return std::nullopt;
    return Cut{std::move(boundaries), stretch ? seconds(stretch->end()) : 0};
}

}  // namespace

std::optional<std::string> disagreement(World& world, const Plan* plan, const std::string& failure) {
    const std::string own = plan ? "scene " + std::to_string(plan->scene.fingerprint()) + " of " +
                                       std::to_string(plan->shards.size()) + " shards"
                                 : failure;
    const std::vector<std::string> all = world.gather((plan ? "+" : "-") + own);
    std::string verdict;
    for (std::size_t rank = 0; rank < all.size() && verdict.empty(); ++rank) {
        // A scene that is wrong is so at every rank.
        if (all[rank].starts_with('-'))
            verdict = (rank == 0 ? "" : "rank " + std::to_string(rank) + ": ") + all[rank].substr(1);
        else if (all[rank] != all[0])
            verdict = "rank " + std::to_string(rank) +
                      " has read another scene than rank 0, or is another version of this program";
    }
    verdict = world.broadcast(verdict);
    return verdict.empty() ? std::nullopt : std::optional(verdict);
}

Share share_out(World& world, Plan& plan) {
    Share share{.samples_are_sent = !is_known_before(plan), .measured_s = 0, .afferents = {}};
    std::optional<Cut> by_load;
    if (!share.samples_are_sent && plan.addresses >= worth_measuring) by_load = cut_by_load(world, plan);
    if (by_load) share.measured_s = by_load->measured_s;
    const auto boundaries = by_load ? by_load->boundaries : cut(counts_of(plan), world.size());
    for (std::size_t rank = 0; rank < world.size(); ++rank) {
        std::uint64_t afferents = 0;
        for (const Plan::ShardPlan& shard : range(plan.shards, boundaries, rank)) afferents += shard.count;
        share.afferents.push_back(afferents);
    }
    plan.shards = range(plan.shards, boundaries, world.rank());
    // Ranks on the same machine share its processors.
    const std::size_t processors =
        std::max<std::size_t>(1, std::thread::hardware_concurrency() / world.neighbours());
    if (plan.scene.runtime.threads == 0) plan.threads = std::min(plan.threads, processors);
    return share;
}

}  // namespace afferent::ranks
