#include "afferent/decoders/afferent_builder.hpp"

#include <functional>

namespace afferent {
namespace {

// Groups of different neurons rarely have the same drive, so the neuron is left out.
std::size_t hash_of(const DecodedAfferents::Group& group) {
    std::size_t hash = 0;
    for (const double value :
         {group.drive_mv_per_n, group.bias_mv, group.drive_mv_s_per_n, group.full_scale_n})
        hash = hash * 0x9e3779b97f4a7c15 + std::hash<double>()(value);
    return hash;
}

}  // namespace

AfferentBuilder::AfferentBuilder(DecodedAfferents& afferents) : afferents_(afferents) {
    for (std::uint32_t i = 0; i < afferents.groups.size(); ++i)
        groups_.emplace(hash_of(afferents.groups[i]), i);
}

void AfferentBuilder::add(Address address, const DecodedAfferents::Group& group, double share,
                          std::uint32_t patch) {
    afferents_.afferents.push_back({address, index_of(group), share, patch});
}

std::uint32_t AfferentBuilder::index_of(const DecodedAfferents::Group& group) {
    const std::size_t hash = hash_of(group);
    const auto [begin, end] = groups_.equal_range(hash);
    for (auto it = begin; it != end; ++it)
        if (afferents_.groups[it->second] == group) return it->second;
    const auto index = static_cast<std::uint32_t>(afferents_.groups.size());
    afferents_.groups.push_back(group);
    groups_.emplace(hash, index);
    return index;
}

}  // namespace afferent
