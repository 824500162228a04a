#include "afferent/neurons/tuning.hpp"

#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>

#include "afferent/neurons/rate.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr double largest_delta_g = 1e6;

RateKind other(RateKind kind) { return kind == RateKind::steady ? RateKind::onset : RateKind::steady; }

const char* name(RateKind kind) { return kind == RateKind::steady ? "steady" : "onset"; }

// The Δg at which the drive that gives the target's rate also gives the other rate. The ratio of onset to
// steady rate rises with Δg from 1.
double solve_delta_g(const NeuronModel& model, const TuningTarget& target) {
    const auto miss_hz = [&](double delta_g) {
        const NeuronModel adapting = with_adaptation(model, delta_g);
        const double drive = drive_mv(target.rate, adapting, target.rate_hz);
        return rate_hz(other(target.rate), adapting, drive) - *target.other_rate_hz;
    };
    const double at_zero = miss_hz(0);
    if (at_zero == 0) return 0;
    double high = 1e-3;
    while (high < largest_delta_g && std::signbit(miss_hz(high)) == std::signbit(at_zero)) high *= 2;
    if (high >= largest_delta_g)
        throw ParameterError("other_rate_hz",
                             std::string("a rate that adaptation can reach: the ") +
                                 name(other(target.rate)) + " rate beside a " + name(target.rate) +
                                 " rate of " + std::to_string(target.rate_hz) + " Hz",
                             *target.other_rate_hz);
    std::uintmax_t iterations = 200;
    const auto [a, b] = boost::math::tools::toms748_solve(
        miss_hz, 0.0, high, boost::math::tools::eps_tolerance<double>(50), iterations);
    return (a + b) / 2;
}

}  // namespace

void TuningTarget::check() const {
    require(rate_hz > 0, "rate_hz", "> 0", rate_hz);
    require(begin_input >= 0, "begin_force_n", ">= 0", begin_input);
    require(input > begin_input, "force_n", "> begin_force_n", input);
    if (other_rate_hz) require(*other_rate_hz > 0, "other_rate_hz", "> 0", *other_rate_hz);
}

Tuned tune(const NeuronModel& model, const TuningTarget& target) {
    target.check();
    for (const std::optional<double> rate : {std::optional(target.rate_hz), target.other_rate_hz})
        if (rate && *rate * refractory(model).count() >= 1000)
            throw ParameterError("rate_hz", "below the reciprocal of the refractory period", *rate);
    const double delta_g = target.other_rate_hz ? solve_delta_g(model, target) : adaptation(model);
    const NeuronModel tuned = with_adaptation(model, delta_g);
    const double drive = drive_mv(target.rate, tuned, target.rate_hz);
    const double rheobase = rheobase_mv(tuned);
    // Where the interval is so long that its drive rounds to the rheobase, there is no gain to solve for.
    require(drive > rheobase, "rate_hz", "high enough to be told from silence", target.rate_hz);
    const double gain = (drive - rheobase) / (target.input - target.begin_input);
    const double bias = rheobase - gain * target.begin_input;
    return {gain, bias, delta_g, rate_hz(target.rate, tuned, gain * target.input + bias) - target.rate_hz};
}

}  // namespace afferent
