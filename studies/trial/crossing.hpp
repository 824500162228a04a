// Finds the parameter at which a proportion that is counted comes to a target.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "afferent/studies/trial/proportion_interval.hpp"

namespace afferent {

struct CrossingSearch {
    double low;  // > 0: the range in which it is looked for
    double high;
    double target;  // in (0, 1)
    std::uint32_t presentations;
    double tolerance = 0.001;  // of the proportion that is found
};

struct Crossing {
    double parameter;
    Proportion counted;  // there
    // The standard deviation of the parameter that comes of counting finitely many presentations.
    double sigma;
    // False: the target is beyond what the range reaches, and this is its nearer end.
    bool is_reached;
};

// Counts presentations at a parameter; none: it was interrupted.
using CountAt = std::function<std::optional<Proportion>(double parameter, std::uint32_t presentations)>;

// The proportion is monotonic in the parameter, but for what chance does: the same presentations are counted
// at every parameter. Few of them bracket the crossing, all of them are counted near it. None: interrupted.
std::optional<Crossing> find_crossing(const CrossingSearch& search, const CountAt& count);

}  // namespace afferent
