#include "afferent/hand/trial_user.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/hand/random.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {

TrialUser::TrialUser(const Parameters& parameters, double force_limit_n, std::uint64_t seed)
    : parameters_(parameters), force_limit_n_(force_limit_n), seed_(seed) {
    const auto not_negative = [](const char* field, double value) {
        require(value >= 0, field, ">= 0", value);
    };
    const auto positive = [](const char* field, double value) { require(value > 0, field, "> 0", value); };
    positive("users", parameters.users);
    not_negative("begin_s", parameters.begin_s);
    require(parameters.reach_effort > 0 && parameters.reach_effort <= 1, "reach_effort", "> 0 and at most 1",
            parameters.reach_effort);
    not_negative("reach_spread", parameters.reach_spread);
    positive("aim_n", parameters.aim_n);
    not_negative("aim_spread", parameters.aim_spread);
    not_negative("user_spread", parameters.user_spread);
    not_negative("reaction_ms", parameters.reaction_ms);
    not_negative("reaction_spread", parameters.reaction_spread);
    not_negative("delay_ms", parameters.delay_ms);
    positive("contraction_ms", parameters.contraction_ms);
    not_negative("grip_s", parameters.grip_s);
    positive("lift_s", parameters.lift_s);
    positive("lift_mm_per_s", parameters.lift_mm_per_s);
    not_negative("settle_s", parameters.settle_s);
    not_negative("hold_s", parameters.hold_s);
    require(parameters.slip_effort >= 1, "slip_effort", ">= 1", parameters.slip_effort);
    positive("patience_s", parameters.patience_s);
    not_negative("press_on", parameters.press_on);
}

TrialUser::Intent TrialUser::intent(std::uint32_t number, double aim_factor) const noexcept {
    const auto factor = [&](double spread, Stream stream, std::uint32_t address) {
        return std::exp(spread * gaussian(seed_, stream, address, 0));
    };
    const double aim_n = parameters_.aim_n * aim_factor *
                         factor(parameters_.user_spread, Stream::trial_user, number % parameters_.users) *
                         factor(parameters_.aim_spread, Stream::trial_aim, number);
    return {.aimed_force_n = aim_n,
            .reach_effort = std::min(1.0, parameters_.reach_effort *
                                              factor(parameters_.reach_spread, Stream::trial_reach, number)),
            .grip_effort = std::min(1.0, aim_n / force_limit_n_),
            .reaction_s = parameters_.reaction_ms / 1000 *
                          factor(parameters_.reaction_spread, Stream::trial_reaction, number)};
}

double TrialUser::lift_at_s(const Intent& intent, double contact_s) const noexcept {
    return contact_s + intent.reaction_s + parameters_.grip_s;
}

double TrialUser::aimed_effort(const Intent& intent, double time_s, const Seen& seen) const noexcept {
    const double t = time_s - parameters_.delay_ms / 1000;
    if (t < parameters_.begin_s) return 0;
    if (!seen.contact_s || t < *seen.contact_s + intent.reaction_s)
        return t < parameters_.begin_s + parameters_.patience_s ? intent.reach_effort : 0;
    const double grip_effort = intent.grip_effort * (1 + parameters_.press_on * seen.weakness);
    if (seen.slip_s && t >= *seen.slip_s + intent.reaction_s)
        return std::min(1.0, parameters_.slip_effort * grip_effort);
    const double relax_s = lift_at_s(intent, *seen.contact_s) + parameters_.lift_s + parameters_.settle_s;
    return t < relax_s ? std::min(1.0, grip_effort) : 0;
}

double TrialUser::lifted(const Intent& intent, double time_s, const Seen& seen) const noexcept {
    if (!seen.contact_s) return 0;
    return std::clamp((time_s - lift_at_s(intent, *seen.contact_s)) / parameters_.lift_s, 0.0, 1.0);
}

double TrialUser::end_s(const Intent& intent, const Seen& seen) const noexcept {
    if (!seen.contact_s) return parameters_.begin_s + parameters_.patience_s;
    return lift_at_s(intent, *seen.contact_s) + parameters_.lift_s + parameters_.settle_s +
           parameters_.hold_s;
}

}  // namespace afferent
