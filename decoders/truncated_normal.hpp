// The standard normal distribution between two limits, and its first moments.
#pragma once

namespace afferent {

struct TruncatedNormal {
    double mean;
    double variance;
    double log_mass;  // log of the probability of lying between the limits
};

// low < high. Keeps its digits far out in either tail.
TruncatedNormal truncated_normal(double low, double high) noexcept;

}  // namespace afferent
