#include "afferent/hand/prosthesis_motor.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {

ProsthesisMotor::ProsthesisMotor(const Parameters& parameters) : parameters_(parameters) {
    require(parameters.aperture_mm > 0, "aperture_mm", "> 0", parameters.aperture_mm);
    require(parameters.closing_s > 0, "closing_s", "> 0", parameters.closing_s);
    require(parameters.force_limit_n > 0, "force_limit_n", "> 0", parameters.force_limit_n);
    require(parameters.time_constant_ms > 0, "time_constant_ms", "> 0", parameters.time_constant_ms);
    require(parameters.dead_band >= 0 && parameters.dead_band < 1, "dead_band", ">= 0 and < 1",
            parameters.dead_band);
}

void ProsthesisMotor::advance(double command, double force_n, Duration dt) noexcept {
    double u = std::isfinite(command) ? std::clamp(command, -1.0, 1.0) : 0;
    if (std::abs(u) <= parameters_.dead_band) u = 0;
    if (u > 0) u = std::max(0.0, u - force_n / parameters_.force_limit_n);
    const double target = u * parameters_.aperture_mm / parameters_.closing_s;

    // Exact over the step for a held target.
    const double tau_s = parameters_.time_constant_ms / 1000;
    const double settled = -std::expm1(-seconds(dt) / tau_s);
    const double speed = state_.speed_mm_per_s;
    state_.position_mm += target * seconds(dt) + (speed - target) * tau_s * settled;
    state_.speed_mm_per_s = speed + (target - speed) * settled;
    if (state_.position_mm <= 0 || state_.position_mm >= parameters_.aperture_mm)
        state_ = {std::clamp(state_.position_mm, 0.0, parameters_.aperture_mm), 0};
}

}  // namespace afferent
