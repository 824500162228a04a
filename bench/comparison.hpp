// A solver's spikes against the true ones.
#pragma once

#include <cstddef>
#include <vector>

#include "bench/workload.hpp"

namespace afferent::bench {

// Spikes are paired one to one, in order, where they are closer than half the interval to the next true
// spike. Those left over are missed or extra.
struct Comparison {
    std::vector<double> errors_s;  // absolute, of the pairs
    double worst_beyond_s =
        0;  // the largest error beyond max(1 ns, 1e-12 of the time since the beginning); 0: none
    std::size_t missed = 0;
    std::size_t extra = 0;

    void add(const Train& truth, const Train& train);

    double quantile_s(double share) const;
    double rms_s() const;
    double max_s() const;
};

}  // namespace afferent::bench
