#include "afferent/decoders/emg_control.hpp"

#include <algorithm>
#include <cmath>

namespace afferent {
namespace {

// The command of a hand that opens by itself.
constexpr double opening_command = -0.5;

double within_0_and_1(double effort) { return std::isnan(effort) ? 0 : std::clamp(effort, 0.0, 1.0); }

}  // namespace

GripCommand EmgControl::operator()(const Estimate& estimate, GripState state,
                                   const Effort& effort) const noexcept {
    if (state == GripState::safe && safe_state_ == SafeState::open) return {0, opening_command};
    const double gain = state == GripState::operating ? gain_(estimate) : 0;
    // If the opening effort is unknown, the user may be trying to open: do not close.
    const double closing = std::isnan(effort.opening) ? 0 : within_0_and_1(effort.closing);
    return {gain, std::clamp(gain * closing - within_0_and_1(effort.opening), -1.0, 1.0)};
}

}  // namespace afferent
