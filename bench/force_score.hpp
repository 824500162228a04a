// How well a force has been followed.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "afferent/decoders/estimate.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

struct ForceScore {
    double rms_n = 0;
    double rms_sensed_n = 0;  // against the force as the sensors read it
    double p95_n = 0;         // 95th percentile of the absolute error
    // The mean error while the force stays within 2 % of what it was 0.4 s ago, and above a tenth of its
    // largest.
    double hold_bias_n = 0;
    // The largest excess of the estimate in the half second after the force rises past a twentieth of its
    // largest.
    double overshoot_n = 0;
    double delay_ms = 0;  // at which the estimate correlates best with the force
    // The fraction of forces within 1.96 standard deviations; nothing where the scheme states none.
    std::optional<double> coverage_95 = {};
};

// Forces and their estimates, at the same steps of one length.
struct FollowedForce {
    std::span<const double> true_n;
    std::span<const double> sensed_n;
    std::span<const double> decodable_n;  // for bias and coverage
    std::vector<Estimate> estimates;
};

// Over all steps of all forces; the overshoot is the largest of them, bias and delay are their means.
ForceScore score(std::span<const FollowedForce> forces, Duration step);

}  // namespace afferent
