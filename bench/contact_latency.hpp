// Question: how long from a contact to the command that answers it, by decoder?
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "afferent/scene/scene.hpp"

namespace afferent::bench {

// In virtual time: the same on every machine. Quantiles are over the delicate objects whose contact was
// answered, as Presentation::answer_s defines it; absent where none was.
struct ContactLatency {
    std::string condition;
    std::string chain;  // the scene's, or what stands in its place
    double budget_ms;   // what the plan allows the chain at most, without the time to the first spike
    std::optional<double> told_median_ms;  // Presentation::told_s
    std::uint64_t answered;
    std::optional<double> p10_ms;
    std::optional<double> median_ms;
    std::optional<double> p90_ms;
};

// A row for `force` and for each decoder, first for the scene as it is and then with sensors at 1 kHz and
// prompt_ms 1; for a scene that has these, with sensors at 200 Hz and without prompt_ms. `progress` is told
// the fraction that is done. Throws SceneError unless the scene has a trial.
std::vector<ContactLatency> measure_contact_latency(const Scene& scene, std::uint32_t presentations,
                                                    const std::function<void(double)>& progress);
void print_contact_latency(const std::vector<ContactLatency>& rows, std::ostream& out);

}  // namespace afferent::bench
