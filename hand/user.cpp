#include "afferent/hand/user.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "afferent/hand/random.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// 1 from `begin` for `length`, with linear flanks of the ramp's duration inside.
double pulse(double t, double begin, double length, double ramp) {
    return std::clamp(std::min((t - begin) / ramp, (begin + length - t) / ramp), 0.0, 1.0);
}

}  // namespace

User::User(const Parameters& parameters, std::uint64_t seed) : parameters_(parameters), seed_(seed) {
    require(parameters.close_at_s >= 0, "close_at_s", ">= 0", parameters.close_at_s);
    require(parameters.close_for_s >= 0, "close_for_s", ">= 0", parameters.close_for_s);
    require(parameters.hold_for_s >= 0, "hold_for_s", ">= 0", parameters.hold_for_s);
    require(parameters.open_for_s >= 0, "open_for_s", ">= 0", parameters.open_for_s);
    require(parameters.ramp_s > 0, "ramp_s", "> 0", parameters.ramp_s);
    require(parameters.effort >= 0 && parameters.effort <= 1, "effort", "0 to 1", parameters.effort);
    require(parameters.hold_effort >= 0 && parameters.hold_effort <= 1, "hold_effort", "0 to 1",
            parameters.hold_effort);
}

double User::closing_effort(TimePoint time) const noexcept {
    const double t = seconds(time);
    const double hold_at = parameters_.close_at_s + parameters_.close_for_s;
    const double close = pulse(t, parameters_.close_at_s, parameters_.close_for_s, parameters_.ramp_s);
    const double hold = t >= hold_at && t < hold_at + parameters_.hold_for_s ? 1 : 0;
    return std::max(parameters_.effort * close, parameters_.hold_effort * hold);
}

double User::opening_effort(TimePoint time) const noexcept {
    const double open_at = parameters_.close_at_s + parameters_.close_for_s + parameters_.hold_for_s;
    return parameters_.effort * pulse(seconds(time), open_at, parameters_.open_for_s, parameters_.ramp_s);
}

Emg User::emg(TimePoint time, std::uint64_t index) const noexcept {
    // The mean absolute value of a normal number is sqrt(2/pi) of its standard deviation.
    const double sigma = full_scale_counts * std::sqrt(std::numbers::pi / 2);
    const auto sample = [&](Stream stream, double effort) {
        return std::round(rest_counts + sigma * effort * gaussian(seed_, stream, 0, index));
    };
    return {sample(Stream::closing_emg, closing_effort(time)),
            sample(Stream::opening_emg, opening_effort(time))};
}

}  // namespace afferent
