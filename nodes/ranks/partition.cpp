#include "afferent/nodes/ranks/partition.hpp"

#include <algorithm>
#include <numeric>

namespace afferent::ranks {
namespace {

// Gives each rank, from the last on, as much as it may have. False if something is left over.
bool fill(std::span<const double> loads, double most, double extra, std::vector<std::size_t>& boundaries) {
    std::size_t end = loads.size();
    for (std::size_t rank = boundaries.size() - 1; rank-- > 0;) {
        boundaries[rank + 1] = end;
        double load = rank == 0 ? extra : 0;
        while (end > 0 && load + loads[end - 1] <= most) load += loads[--end];
    }
    boundaries[0] = 0;
    return end == 0;
}

}  // namespace

std::vector<std::size_t> cut(std::span<const double> loads, std::size_t ranks, double extra) {
    std::vector<std::size_t> boundaries(ranks + 1);
    double enough = extra + std::accumulate(loads.begin(), loads.end(), 0.0);
    double too_little = 0;
    // Each step halves the interval: enough for every digit of a load that is a measurement.
    for (int i = 0; i < 40; ++i) {
        const double middle = (too_little + enough) / 2;
        (fill(loads, middle, extra, boundaries) ? enough : too_little) = middle;
    }
    // Sums of the same loads in another order may come out larger by their rounding.
    fill(loads, enough * (1 + 1e-9), extra, boundaries);
    return boundaries;
}

std::vector<double> with_counts(std::vector<double> loads, std::span<const double> counts) {
    const double load = std::accumulate(loads.begin(), loads.end(), 0.0);
    const double count = std::accumulate(counts.begin(), counts.end(), 0.0);
    const double weight = (load > 0 ? 1e-3 * load : 1) / count;
    for (std::size_t i = 0; i < loads.size(); ++i) loads[i] += weight * counts[i];
    return loads;
}

}  // namespace afferent::ranks
