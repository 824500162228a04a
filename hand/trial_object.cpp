#include "afferent/hand/trial_object.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/hand/random.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr double gravity_mm_per_s2 = 9806.65;
// More than half of all draws are above the median, and so above the least force.
constexpr std::uint64_t most_draws = 64;

double log_normal(double median, double spread, double z) { return median * std::exp(spread * z); }

}  // namespace

double TrialObject::force_n(double position_mm) const noexcept {
    const double indentation_mm =
        position_mm - parameters_.distance_mm - parameters_.taper * state_.slipped_mm;
    return parameters_.stiffness_n_per_mm * std::max(0.0, indentation_mm);
}

void TrialObject::advance(double position_mm, double lifted, Duration dt) noexcept {
    const double force = force_n(position_mm);
    if (parameters_.breaking_force_n && force > *parameters_.breaking_force_n) state_.broken = true;
    const double load_n = lifted * parameters_.weight_n;
    const double carried_n = 2 * parameters_.friction * force;
    if (!state_.slips() && load_n <= carried_n) {
        state_.carried = state_.carried || lifted >= 1;
        return;
    }
    const double acceleration = gravity_mm_per_s2 * (load_n - carried_n) / parameters_.weight_n;
    state_.slip_mm_per_s = std::max(0.0, state_.slip_mm_per_s + acceleration * seconds(dt));
    if (!state_.carried) state_.slip_mm_per_s = std::min(state_.slip_mm_per_s, parameters_.lift_mm_per_s);
    state_.slipped_mm += state_.slip_mm_per_s * seconds(dt);
}

void TrialObjects::check() const {
    const auto positive = [](const char* field, double value) { require(value > 0, field, "> 0", value); };
    const auto not_negative = [](const char* field, double value) {
        require(value >= 0, field, ">= 0", value);
    };
    positive("object.stiffness_n_per_mm", delicate.stiffness_n_per_mm);
    not_negative("object.stiffness_spread", delicate.stiffness_spread);
    not_negative("object.least_breaking_force_n", delicate.least_breaking_force_n);
    require(delicate.breaking_force_n > delicate.least_breaking_force_n, "object.breaking_force_n",
            "> least_breaking_force_n", delicate.breaking_force_n);
    not_negative("object.breaking_spread", delicate.breaking_spread);
    positive("object.weight_n", delicate.weight_n);
    positive("object.friction", delicate.friction);
    not_negative("object.distance_mm", delicate.distance_mm);
    not_negative("object.distance_spread", delicate.distance_spread);
    require(slippery.part >= 0 && slippery.part <= 1, "slippery.part", "0 to 1", slippery.part);
    positive("slippery.stiffness_n_per_mm", slippery.stiffness_n_per_mm);
    not_negative("slippery.stiffness_spread", slippery.stiffness_spread);
    positive("slippery.weight_n", slippery.weight_n);
    not_negative("slippery.weight_spread", slippery.weight_spread);
    positive("slippery.friction", slippery.friction);
    not_negative("slippery.taper", slippery.taper);
    not_negative("slippery.distance_mm", slippery.distance_mm);
    not_negative("slippery.distance_spread", slippery.distance_spread);
    positive("slippery.aim_factor", slippery.aim_factor);
}

bool TrialObjects::is_slippery(std::uint64_t seed, std::uint32_t number) const noexcept {
    return uniform(seed, Stream::trial_kind, number, 0) < slippery.part;
}

TrialObject::Parameters TrialObjects::object(std::uint64_t seed, std::uint32_t number) const noexcept {
    const auto z = [&](Stream stream, std::uint64_t index = 0) {
        return gaussian(seed, stream, number, index);
    };
    if (is_slippery(seed, number))
        return {.stiffness_n_per_mm = log_normal(slippery.stiffness_n_per_mm, slippery.stiffness_spread,
                                                 z(Stream::trial_stiffness)),
                .distance_mm =
                    log_normal(slippery.distance_mm, slippery.distance_spread, z(Stream::trial_distance)),
                .breaking_force_n = {},
                .weight_n = log_normal(slippery.weight_n, slippery.weight_spread, z(Stream::trial_weight)),
                .friction = slippery.friction,
                .taper = slippery.taper};
    double breaking_n = delicate.breaking_force_n;
    for (std::uint64_t draw = 0; draw < most_draws; ++draw) {
        const double drawn =
            log_normal(delicate.breaking_force_n, delicate.breaking_spread, z(Stream::trial_breaking, draw));
        if (drawn < delicate.least_breaking_force_n) continue;
        breaking_n = drawn;
        break;
    }
    return {
        .stiffness_n_per_mm =
            log_normal(delicate.stiffness_n_per_mm, delicate.stiffness_spread, z(Stream::trial_stiffness)),
        .distance_mm = log_normal(delicate.distance_mm, delicate.distance_spread, z(Stream::trial_distance)),
        .breaking_force_n = breaking_n,
        .weight_n = delicate.weight_n,
        .friction = delicate.friction,
        .taper = 0};
}

}  // namespace afferent
