#include "afferent/engine/scan_routes.hpp"

namespace afferent {

ScanRoutes::ScanRoutes(const Plan& plan) : begins_(plan.elements / block + 2), visited_(plan.shards.size()) {
    const auto for_each_block = [&](auto&& use) {
        for (std::uint32_t i = 0; i < plan.shards.size(); ++i) {
            const Plan::ShardPlan& shard = plan.shards[i];
            const PatchPlan& patch = plan.patches[shard.patch];
            const ElementRange read = patch.fields.read_by(shard.begin, shard.count);
            for (std::uint32_t k = (patch.first_element + read.begin) / block;
                 k <= (patch.first_element + read.end - 1) / block; ++k)
                use(k, i);
        }
    };
    // Throws where a shard reads beyond the elements, rather than write there.
    for_each_block([&](std::uint32_t k, std::uint32_t) { ++begins_.at(k + 1); });
    for (std::size_t k = 1; k < begins_.size(); ++k) begins_[k] += begins_[k - 1];
    shards_.resize(begins_.back());
    std::vector<std::uint32_t> next(begins_.begin(), begins_.end() - 1);
    for_each_block([&](std::uint32_t k, std::uint32_t i) { shards_[next[k]++] = i; });
}

}  // namespace afferent
