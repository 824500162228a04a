#include "afferent/decoders/slip_pulse.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr double widest_dead_band = 0.1;

}  // namespace

SlipPulse::SlipPulse(const Parameters& parameters) : parameters_(parameters) {
    require(parameters.command > 0 && parameters.command <= 1, "pulse.command", "> 0 and at most 1",
            parameters.command);
    require(parameters.pulse > 0ns, "pulse.pulse_ms", "> 0", Milliseconds(parameters.pulse).count());
    require(parameters.fall_n > 0, "pulse.fall_n", "> 0", parameters.fall_n);
    require(parameters.fall_sigmas >= 0, "pulse.fall_sigmas", ">= 0", parameters.fall_sigmas);
    require(parameters.within > 0ns, "pulse.within_ms", "> 0", Milliseconds(parameters.within).count());
    require(parameters.settle >= 0ns, "pulse.settle_ms", ">= 0", Milliseconds(parameters.settle).count());
    require(parameters.most >= 1, "pulse.most", ">= 1", parameters.most);
    require(parameters.dead_band >= 0 && parameters.dead_band < 1, "motor.dead_band", ">= 0 and < 1",
            parameters.dead_band);
}

double SlipPulse::operator()(TimePoint now, const Estimate& estimate, bool heard, GripState grip, double gain,
                             double command) noexcept {
    if (heard) follow(now, estimate.force_n);
    const bool may_close = grip == GripState::operating && estimate.doubt <= Doubt::slow && gain > 0 &&
                           command >= -std::min(parameters_.dead_band, widest_dead_band);
    if (!may_close || (state_ == State::pulsing && now >= until_)) rest(now);
    if (state_ == State::resting && now >= until_) state_ = State::watching;
    if (state_ == State::watching && heard && pulses_ < parameters_.most && slips(now, estimate)) {
        state_ = State::pulsing;
        until_ = now + parameters_.pulse;
        ++pulses_;
    }
    if (state_ != State::watching) peak_n_ = force_n_;
    return state_ == State::pulsing ? std::max(command, parameters_.command * gain) : command;
}

void SlipPulse::follow(TimePoint now, double force_n) noexcept {
    const Duration step = now - last_;
    last_ = now;
    if (std::isfinite(force_n)) force_n_ = force_n;
    const double kept = std::exp(-seconds(step) / seconds(parameters_.within));
    peak_n_ = std::max(force_n_, force_n_ + (peak_n_ - force_n_) * kept);
    follow_contact(now);
}

void SlipPulse::follow_contact(TimePoint now) noexcept {
    if (force_n_ >= parameters_.fall_n) {
        touched_ = now;
        if (!in_contact_) contact_ = now;
        in_contact_ = true;
    } else if (now - touched_ >= parameters_.within) {
        in_contact_ = false;
        pulses_ = 0;
    }
}

void SlipPulse::rest(TimePoint now) noexcept {
    state_ = State::resting;
    until_ = now + parameters_.within;
}

// Where nothing is felt any more, nothing is left to hold.
bool SlipPulse::slips(TimePoint now, const Estimate& estimate) const noexcept {
    return now - contact_ >= parameters_.settle && estimate.force_n >= parameters_.fall_n &&
           peak_n_ - force_n_ >= std::max(parameters_.fall_n, parameters_.fall_sigmas * estimate.sigma_n);
}

}  // namespace afferent
