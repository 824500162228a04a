// How far the decoder `filter` is from what its force model and the same spikes allow.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "bench/touch.hpp"

namespace afferent {

// Against the force as the sensors read it, without a model of their hysteresis, in packets of 5 ms and ticks
// of 100 us. The judge is the best of several runs of the particles, which may lose a force whose afferents
// are all alike.
struct Judgement {
    std::string scene;
    std::uint32_t elements;
    double filter_rms_n;
    double particles_rms_n;
    // Above 1 the filter loses something. Below, its approximations suit the force better than its model
    // does.
    double ratio() const noexcept { return filter_rms_n / particles_rms_n; }
};

// Judges the touches whose forces have at most nine afferents each; with more, the particles take too long.
// `progress` is told the fraction that is done, from one thread at a time.
std::vector<Judgement> judge_filter(const std::vector<Touch>& touches, std::uint64_t runs,
                                    const std::function<void(double)>& progress);

// judge.csv. Throws std::runtime_error where it cannot be written.
void write_judgements(const std::vector<Judgement>& judgements, const std::filesystem::path& folder);
void print_judgements(const std::vector<Judgement>& judgements, std::ostream& out);

}  // namespace afferent
