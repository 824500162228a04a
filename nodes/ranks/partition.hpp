// Which rank computes which shards.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace afferent::ranks {

// Cuts pieces, each with a load >= 0, into one contiguous range for each rank, such that the most loaded rank
// has as little as it can; rank 0 has `extra` to do besides. Rank r gets the pieces from boundary r up to
// boundary r + 1; a range may be empty. Where there is a choice, ranks with lower numbers have less.
std::vector<std::size_t> cut(std::span<const double> loads, std::size_t ranks, double extra = 0);

// Loads by which to cut shards that were measured over the beginning of a scene, given how many afferents
// each has. Shards that were idle then may be busy later: besides its load, each has its part by count of a
// thousandth of all load, or of 1 where nothing was measured.
std::vector<double> with_counts(std::vector<double> loads, std::span<const double> counts);

}  // namespace afferent::ranks
