#include "afferent/scene/form.hpp"

#include <optional>

#include "afferent/neurons/dense_population.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// Fewer neurons than this do not fill the vectors of a sweep often enough to pay for it.
constexpr std::uint32_t worth_sweeping = 512;

std::optional<std::string> dense_refusal(const Scene& scene, const Patch& patch, Duration scan_interval) {
    const proto::Source& source = scene.description().source();
    const bool clocked = source.has_simulated_hand() || source.has_profile() ||
                         source.kind_case() == proto::Source::KIND_NOT_SET;
    if (!clocked) return "the samples come at times of their own";
    const double rate_hz = scene.patches()[patch.reads].rate_hz;
    if (sample_time(1'000'000, rate_hz) - scene_start != 1'000'000 * scan_interval)
        return "the sampling interval is not a whole number of nanoseconds";
    return DensePopulation::refusal(patch.neuron, scan_interval);
}

}  // namespace

Form form_of(const Scene& scene, const Patch& patch) {
    const proto::Form asked =
        scene.description().patch(static_cast<int>(&patch - scene.patches().data())).neuron().form();
    const Duration scan_interval = sample_time(1, scene.patches()[patch.reads].rate_hz) - scene_start;
    if (asked == proto::SPARSE) return {false, scan_interval, "neuron.form is SPARSE"};
    const auto refusal = dense_refusal(scene, patch, scan_interval);
    if (asked == proto::DENSE) {
        if (refusal) throw ParameterError("form", "SPARSE here", "DENSE: " + *refusal);
        return {true, scan_interval, "neuron.form is DENSE"};
    }
    if (refusal) return {false, scan_interval, *refusal};
    if (patch.elements < worth_sweeping)
        return {false, scan_interval, std::to_string(patch.elements) + " neurons are too few to sweep"};
    return {true, scan_interval, std::to_string(patch.elements) + " neurons on one clock"};
}

}  // namespace afferent
