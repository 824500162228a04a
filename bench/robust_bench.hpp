// Question: what is an estimate worth where the world is not as the decoder is told? Every decoder on the
// same events, for every case of robust_cases.hpp.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "bench/robust_cases.hpp"

namespace afferent {

// Scores over the judged time of all draws. Those without a unit in their name are fractions of that time.
struct RobustScore {
    double rms_n = 0;
    double bias_n = 0;         // the estimate less the true force
    double coverage_95 = 0;    // the true force is within 1.96 sigma
    double above_2_sigma = 0;  // the true force is above the estimate by more than 2 sigma
    double left_out = 0;       // afferents, in the mean
    double saturated = 0;      // Doubt::saturated
    double doubtful = 0;       // any doubt
    std::size_t steps = 0;

    void add(double true_n, const Estimate& estimate);
    // Turns the sums into means.
    void finish();
};

// A row in place of a decoder: the sum of all readings over the sum of the shares that the decoder is told.
// Only a decoder that doubts its description can do better. It has no sigma.
inline constexpr const char* read_by_sensors = "sensors";

struct RobustRow {
    const RobustCase* what;
    std::string scene;
    std::string decoder;
    bool stated = false;  // the decoder is told how large the error is
    RobustScore score = {};
};

struct RobustOptions {
    std::vector<std::string> cases = {};     // prefixes of their names; none: all
    std::vector<std::string> decoders = {};  // by name; none: all, and the sensors
    bool quick = false;
};

// On all processors. `progress` is told the fraction that is done, from one thread at a time. Throws
// std::runtime_error where nothing is called so.
std::vector<RobustRow> measure_robustness(const RobustInput& input, const RobustOptions& options,
                                          const std::function<void(double)>& progress);

}  // namespace afferent
