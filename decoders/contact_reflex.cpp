#include "afferent/decoders/contact_reflex.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr double speed_left = 0.05;

}  // namespace

ContactReflex::ContactReflex(const Parameters& parameters) : parameters_(parameters) {
    require(parameters.command > 0 && parameters.command <= 1, "brake.command", "> 0 and at most 1",
            parameters.command);
    require(parameters.impulse >= 0ns, "brake.impulse_ms", ">= 0", Milliseconds(parameters.impulse).count());
    require(parameters.release_n >= 0, "brake.release_n", ">= 0", parameters.release_n);
    require(parameters.contact_n > parameters.release_n, "brake.contact_n", "> release_n",
            parameters.contact_n);
    require(parameters.release >= 0ns, "brake.release_ms", ">= 0", Milliseconds(parameters.release).count());
    require(parameters.time_constant > 0ns, "motor.time_constant_ms", "> 0",
            Milliseconds(parameters.time_constant).count());
    require(parameters.force_limit_n > 0, "motor.force_limit_n", "> 0", parameters.force_limit_n);
    require(parameters.dead_band >= 0 && parameters.dead_band < 1, "motor.dead_band", ">= 0 and < 1",
            parameters.dead_band);
}

void ContactReflex::restart() noexcept { *this = ContactReflex(parameters_); }

double ContactReflex::operator()(TimePoint now, double force_n, GripState grip, double command) noexcept {
    move(now);
    if (std::isfinite(force_n)) force_n_ = force_n;
    follow_contact(now, grip);
    command_ = state_ == State::braking ? std::min(command, brake(command)) : command;
    return command_;
}

// The speed that the motor approaches.
double ContactReflex::target(double command) const noexcept {
    if (!(std::abs(command) > parameters_.dead_band)) return 0;
    return command < 0 ? command : std::max(0.0, command - force_n_ / parameters_.force_limit_n);
}

// Under the command of the step that ends now.
void ContactReflex::move(TimePoint now) noexcept {
    step_ = now - last_;
    last_ = now;
    const double toward = target(command_);
    speed_ = toward + (speed_ - toward) * std::exp(-seconds(step_) / seconds(parameters_.time_constant));
}

void ContactReflex::follow_contact(TimePoint now, GripState grip) noexcept {
    if (force_n_ >= parameters_.release_n) touched_ = now;
    if (state_ == State::armed && force_n_ >= parameters_.contact_n) {
        state_ = State::braking;
        impulse_left_ = parameters_.impulse;
        slow_enough_ = speed_left * speed_;
    } else if (state_ == State::spent && now - touched_ >= parameters_.release) {
        state_ = State::armed;
    }
    if (state_ == State::braking && grip != GripState::operating) state_ = State::spent;
}

// As strong as is allowed, but no stronger than makes the motor slow enough within a step as long as the
// last.
double ContactReflex::brake(double command) noexcept {
    const double kept = std::exp(-seconds(step_) / seconds(parameters_.time_constant));
    const double ends = kept < 1 ? (speed_ * kept - slow_enough_) / (1 - kept) : parameters_.command;
    const double strength = std::min(parameters_.command, ends);
    const Duration impulse = from_seconds(strength * seconds(step_));
    if (!(strength > parameters_.dead_band) || impulse > impulse_left_) {
        state_ = State::spent;
        return command;
    }
    impulse_left_ -= impulse;
    if (ends <= parameters_.command) state_ = State::spent;
    return -strength;
}

}  // namespace afferent
