#include "afferent/hand/gripper.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {

Gripper::Gripper(const Parameters& parameters) : parameters_(parameters) {
    require(parameters.time_constant_ms > 0, "motor.time_constant_ms", "> 0", parameters.time_constant_ms);
    require(parameters.speed_mm_per_s > 0, "motor.speed_mm_per_s", "> 0", parameters.speed_mm_per_s);
    require(parameters.force_limit_n > 0, "motor.force_limit_n", "> 0", parameters.force_limit_n);
    require(parameters.dead_band >= 0 && parameters.dead_band < 1, "motor.dead_band", ">= 0 and < 1",
            parameters.dead_band);
    require(parameters.stiffness_n_per_mm > 0, "object.stiffness_n_per_mm", "> 0",
            parameters.stiffness_n_per_mm);
    require(parameters.distance_mm >= 0, "object.distance_mm", ">= 0", parameters.distance_mm);
}

void Gripper::resume(const State& state) noexcept {
    state_ = std::isfinite(state.position_mm) && std::isfinite(state.speed_mm_per_s) ? state : State{};
}

double Gripper::force_n() const noexcept {
    return parameters_.stiffness_n_per_mm * std::max(0.0, state_.position_mm - parameters_.distance_mm);
}

void Gripper::advance(double command, Duration dt) noexcept {
    double u = std::isfinite(command) ? std::clamp(command, -1.0, 1.0) : 0;
    if (std::abs(u) < parameters_.dead_band) u = 0;
    const double load = u > 0 ? std::max(0.0, 1 - force_n() / parameters_.force_limit_n) : 1;
    const double target = u * parameters_.speed_mm_per_s * load;

    // Exact over the step for a held target.
    const double tau_s = parameters_.time_constant_ms / 1000;
    const double settled = -std::expm1(-seconds(dt) / tau_s);
    state_.position_mm += target * seconds(dt) + (state_.speed_mm_per_s - target) * tau_s * settled;
    state_.speed_mm_per_s += (target - state_.speed_mm_per_s) * settled;

    // At its ends, fully open and stalled, the motor does not move.
    const double stalled_mm =
        parameters_.distance_mm + parameters_.force_limit_n / parameters_.stiffness_n_per_mm;
    if (state_.position_mm <= 0 || state_.position_mm >= stalled_mm) {
        state_.position_mm = std::clamp(state_.position_mm, 0.0, stalled_mm);
        state_.speed_mm_per_s = 0;
    }
}

}  // namespace afferent
