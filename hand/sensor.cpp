#include "afferent/hand/sensor.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// std::round of counts that are at least 0 and fit into 32 bits. A call of std::round takes as long as all
// else that is done for a sample.
double rounded(double counts) noexcept {
    const double whole = static_cast<std::int32_t>(counts);
    return counts - whole >= 0.5 ? whole + 1 : whole;
}

}  // namespace

Sensor::Sensor(const Parameters& parameters) : parameters_(parameters) {
    require(parameters.full_scale_n > 0, "full_scale_n", "> 0", parameters.full_scale_n);
    require(parameters.adc_bits >= 1 && parameters.adc_bits <= 24, "adc_bits", "1 to 24",
            parameters.adc_bits);
    require(parameters.noise_counts >= 0, "noise_counts", ">= 0", parameters.noise_counts);
    require(parameters.hysteresis >= 0 && parameters.hysteresis < 1, "hysteresis", ">= 0 and < 1",
            parameters.hysteresis);
    if (const auto& curve = parameters.force_resistance) {
        require(curve->minimum_ohm > 0, "force_resistance.minimum_ohm", "> 0", curve->minimum_ohm);
        require(curve->maximum_ohm > curve->minimum_ohm, "force_resistance.maximum_ohm", "> minimum_ohm",
                curve->maximum_ohm);
        require(curve->half_force_n > 0, "force_resistance.half_force_n", "> 0", curve->half_force_n);
        require(curve->divider_ohm > 0, "force_resistance.divider_ohm", "> 0", curve->divider_ohm);
    }
    highest_count_ = std::exp2(parameters.adc_bits) - 1;
}

double Sensor::fraction(double force_n) const noexcept {
    if (const auto& curve = parameters_.force_resistance) {
        const double ohm = curve->minimum_ohm +
                           (curve->maximum_ohm - curve->minimum_ohm) / (1 + force_n / curve->half_force_n);
        return curve->divider_ohm / (curve->divider_ohm + ohm);
    }
    return force_n / parameters_.full_scale_n;
}

double Sensor::counts(State& state, double force_n, double gaussian) const noexcept {
    const double pressed = std::clamp(force_n, 0.0, parameters_.full_scale_n);
    // A play in proportion to the force: what is felt follows once it lags by the hysteresis.
    state.felt_n = std::clamp(state.felt_n, pressed * (1 - parameters_.hysteresis),
                              pressed * (1 + parameters_.hysteresis));
    const double ideal = fraction(state.felt_n) * highest_count_;
    return rounded(std::clamp(ideal + parameters_.noise_counts * gaussian, 0.0, highest_count_));
}

double Sensor::noise_n(double force_n) const noexcept {
    const double step_n = 1e-3 * parameters_.full_scale_n;
    const double counts_per_n = (fraction(force_n + step_n) - fraction(force_n)) / step_n * highest_count_;
    return std::hypot(parameters_.noise_counts, std::sqrt(1.0 / 12)) / counts_per_n;
}

double Sensor::force_n(double counts) const noexcept {
    const double fraction = counts / highest_count_;
    double force = fraction * parameters_.full_scale_n;
    if (const auto& curve = parameters_.force_resistance) {
        // Beyond the end of the curve the divider would take less than the least resistance.
        const double ohm = curve->divider_ohm * (1 - fraction) / fraction;
        if (!(ohm > curve->minimum_ohm)) return parameters_.full_scale_n;
        force = curve->half_force_n *
                ((curve->maximum_ohm - curve->minimum_ohm) / (ohm - curve->minimum_ohm) - 1);
    }
    return std::clamp(force, 0.0, parameters_.full_scale_n);
}

}  // namespace afferent
