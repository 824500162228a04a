#include "afferent/nodes/patch_sensors.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "afferent/hand/random.hpp"

namespace afferent {

namespace {

std::size_t delayed_scans(const scene::Sensor& sensor) {
    // A delay of whole scans is not rounded up to one more.
    return static_cast<std::size_t>(std::ceil(sensor.delay_ms / 1000 * sensor.rate_hz - 1e-9));
}

}  // namespace

PatchSensors::PatchSensors(const PatchPlan& patch, std::uint64_t seed)
    : patch_(patch),
      seed_(seed),
      sensor_(patch.sensor),
      states_(patch.elements()),
      under_way_n_(delayed_scans(patch.sensor)),
      forces_n_(patch.elements()) {}

double PatchSensors::calibrated(double counts) const noexcept {
    return patch_.calibration ? patch_.calibration->force_n(counts) : sensor_.force_n(counts);
}

double PatchSensors::force_n(double counts) const noexcept {
    return calibrated(std::clamp(counts, 0.0, sensor_.highest_count()));
}

template <class Noise>
void PatchSensors::feel(double grip_force_n, const Noise& noise) {
    for (std::uint32_t i = patch_.sampled.begin; i < patch_.sampled.end; ++i) {
        const double force_n = patch_.share[i] * grip_force_n;
        count(i, force_n, sensor_.within_range(force_n));
        forces_n_[i] = calibrated(sensor_.counts(states_[i], force_n, noise(i)));
    }
}

std::span<const double> PatchSensors::feel(double grip_force_n) {
    if (patch_.sensor.noise_counts > 0)
        feel(grip_force_n, [this](std::uint32_t element) {
            return gaussian(seed_, Stream::sensor_noise, patch_.first_element + element, samples_);
        });
    else
        feel(grip_force_n, [](std::uint32_t) { return 0.0; });
    return with_faults().subspan(patch_.sampled.begin, patch_.sampled.size());
}

double PatchSensors::arriving_n(double grip_force_n) noexcept {
    if (under_way_n_.empty()) return grip_force_n;
    return std::exchange(under_way_n_[samples_ % under_way_n_.size()], grip_force_n);
}

std::span<const double> PatchSensors::feel_elements(std::uint32_t first, std::span<const double> forces_n,
                                                    std::uint64_t index) {
    for (std::uint32_t i = 0; i < forces_n.size(); ++i) {
        const std::uint32_t element = first + i;
        const double noise = patch_.sensor.noise_counts > 0 ? gaussian(seed_, Stream::sensor_noise,
                                                                       patch_.first_element + element, index)
                                                            : 0;
        count(element, forces_n[i], sensor_.within_range(forces_n[i]));
        if (patch_.counted.contains(element)) ++single_samples_;
        forces_n_[element] = calibrated(sensor_.counts(states_[element], forces_n[i], noise));
    }
    apply_faults();
    return std::span(forces_n_).subspan(first, forces_n.size());
}

std::span<const double> PatchSensors::take_newtons(std::span<const double> forces_n) {
    for (std::uint32_t i = 0; i < patch_.elements(); ++i) {
        count(i, forces_n[i], sensor_.within_range(forces_n[i]));
        forces_n_[i] = std::clamp(forces_n[i], 0.0, patch_.sensor.full_scale_n);
    }
    return with_faults();
}

std::span<const double> PatchSensors::take_counts(std::span<const double> counts) {
    for (std::uint32_t i = 0; i < patch_.elements(); ++i) {
        count(i, counts[i], counts[i] >= 0 && counts[i] <= sensor_.highest_count());
        forces_n_[i] = force_n(counts[i]);
    }
    return with_faults();
}

void PatchSensors::apply_faults() noexcept {
    for (const std::uint32_t element : patch_.sensor.dead_element) forces_n_[element] = 0;
    for (const scene::StuckElement& stuck : patch_.sensor.stuck_element)
        forces_n_[stuck.element] = stuck.force_n;
}

std::span<const double> PatchSensors::with_faults() {
    apply_faults();
    ++samples_;
    return forces_n_;
}

}  // namespace afferent
