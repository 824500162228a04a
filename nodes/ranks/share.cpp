#include "afferent/nodes/ranks/share.hpp"

#include <algorithm>
#include <cstring>
#include <thread>

#include "afferent/nodes/ranks/load.hpp"
#include "afferent/nodes/ranks/partition.hpp"
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

std::vector<Plan::ShardPlan> range(const std::vector<Plan::ShardPlan>& shards,
                                   const std::vector<std::size_t>& boundaries, std::size_t rank) {
    const auto at = [&](std::size_t i) {
        return shards.begin() + static_cast<std::ptrdiff_t>(boundaries[i]);
    };
    return {at(rank), at(rank + 1)};
}

// Whether each rank computes the samples of the elements that its afferents read.
bool samples_are_computed(const Plan& plan) {
    return is_known_before(plan) && !force_table(plan.scene.source);
}

// The elements of a patch, from the first to the last, that these shards read; size() 0: none.
ElementRange elements_read(const Plan& plan, std::size_t patch, const std::vector<Plan::ShardPlan>& shards) {
    ElementRange read{plan.patches[patch].elements(), 0};
    for (const Plan::ShardPlan& shard : shards) {
        const PatchPlan& reader = plan.patches[shard.patch];
        if (reader.reads != patch) continue;
        const ElementRange range = reader.fields.read_by(shard.begin, shard.count);
        read = {std::min(read.begin, range.begin), std::max(read.end, range.end)};
    }
    return read.begin < read.end ? read : ElementRange{0, 0};
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
    std::optional<Beginning> beginning;
    ShardLoads measured;
    try {
        if (Result<Beginning> found = beginning_of(plan)) beginning = std::move(found.value());
        if (beginning) measured = measure(plan, own, *beginning);
    } catch (const SpikeStormError&) {
        measured = {};
    }
    const std::vector<double> loads = gather_all(world, measured.seconds);
    EventsOfRanks events;
    for (const std::string& bytes : world.gather(to_bytes(measured.events)))
        events.push_back(from_bytes<Event>(bytes));
    std::vector<std::size_t> boundaries;
    if (beginning && loads.size() == plan.shards.size())
        if (const Result<double> rest_s = rest_of_run(plan, *beginning, std::move(events)))
            boundaries =
                cut(with_counts(samples_are_computed(plan) ? with_sampling(loads, plan, *beginning) : loads,
                                counts),
                    world.size(), std::max(0.0, rest_s.value() - beginning->sampling_s));
    boundaries = from_bytes<std::size_t>(world.broadcast(to_bytes(boundaries)));
    if (boundaries.empty()) return std::nullopt;
    return Cut{std::move(boundaries), beginning ? seconds(beginning->end()) : 0};
}

}  // namespace

void share_sampling(Plan& plan, const std::vector<std::size_t>& boundaries, std::size_t rank,
                    bool first_samples_all) {
    for (std::size_t i = 0; i < plan.patches.size(); ++i) {
        PatchPlan& patch = plan.patches[i];
        if (!patch.owns_elements) continue;
        const ElementRange all{0, patch.elements()};
        std::vector<ElementRange> read;
        for (std::size_t r = 0; r + 1 < boundaries.size(); ++r)
            read.push_back(elements_read(plan, i, range(plan.shards, boundaries, r)));
        // The clock of the run takes a patch.
        const bool is_clock = i == plan.patches.front().reads && read.front().size() == 0;
        if (first_samples_all || is_clock) read.front() = all;
        std::size_t last = read.size();
        while (last > 0 && read[last - 1].size() == 0) --last;
        // Those that nobody reads go to the next rank that reads others.
        std::uint32_t counted = 0;
        for (std::size_t r = 0; r <= rank; ++r) {
            if (read[r].size() == 0) continue;
            const std::uint32_t begin = counted;
            counted = r + 1 == last ? all.end : std::max(counted, read[r].end);
            if (r < rank) continue;
            patch.counted = {begin, counted};
            patch.sampled = read[r];
            if (begin < counted)
                patch.sampled = {std::min(begin, read[r].begin), std::max(counted, read[r].end)};
        }
        patch.owns_elements = read[rank].size() > 0;
    }
}

std::string disagreement_in(const std::vector<std::string>& said) {
    for (std::size_t rank = 0; rank < said.size(); ++rank) {
        // A scene that is wrong is so at every rank.
        if (said[rank].starts_with('-'))
            return (rank == 0 ? "" : "rank " + std::to_string(rank) + ": ") + said[rank].substr(1);
        if (said[rank] != said[0])
            return "rank " + std::to_string(rank) +
                   " has read another scene than rank 0, or is another version of this program";
    }
    return "";
}

std::optional<std::string> disagreement(World& world, const Plan* plan, const std::string& failure) {
    const std::string own = plan ? "scene " + std::to_string(plan->scene.fingerprint()) + " of " +
                                       std::to_string(plan->shards.size()) + " shards"
                                 : failure;
    const std::string verdict = world.broadcast(disagreement_in(world.gather((plan ? "+" : "-") + own)));
    return verdict.empty() ? std::nullopt : std::optional(verdict);
}

Share share_out(World& world, Plan& plan, bool first_samples_all) {
    Share share{.samples_are_sent = !is_known_before(plan),
                .measured_s = 0,
                .afferents = {},
                .first_samples_all = first_samples_all || !samples_are_computed(plan)};
    std::optional<Cut> by_load;
    if (!share.samples_are_sent && plan.addresses >= worth_measuring) by_load = cut_by_load(world, plan);
    if (by_load) share.measured_s = by_load->measured_s;
    const auto boundaries = by_load ? by_load->boundaries : cut(counts_of(plan), world.size());
    for (std::size_t rank = 0; rank < world.size(); ++rank) {
        std::uint64_t afferents = 0;
        for (const Plan::ShardPlan& shard : range(plan.shards, boundaries, rank)) afferents += shard.count;
        share.afferents.push_back(afferents);
    }
    if (samples_are_computed(plan))
        share_sampling(plan, boundaries, world.rank(), share.first_samples_all);
    else if (!world.is_first())
        // A table is read by each rank.
        for (PatchPlan& patch : plan.patches) patch.counted = {0, 0};
    plan.shards = range(plan.shards, boundaries, world.rank());
    // Ranks on the same machine share its processors.
    const std::size_t processors =
        std::max<std::size_t>(1, std::thread::hardware_concurrency() / world.neighbours());
    if (plan.scene.runtime.threads == 0) plan.threads = std::min(plan.threads, processors);
    return share;
}

}  // namespace afferent::ranks
