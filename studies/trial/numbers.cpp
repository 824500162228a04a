#include "afferent/studies/trial/numbers.hpp"

#include <algorithm>
#include <array>

namespace afferent {
namespace {

scene::Trial& trial_of(Scene& scene) {
    if (!scene.trial) scene.trial.emplace();
    return *scene.trial;
}

scene::Channel& channel_of(Scene& scene) {
    if (!scene.link.channel) scene.link.channel.emplace();
    return *scene.link.channel;
}

constexpr std::string_view assumed = "assumed";

constexpr std::array numbers{
    TrialNumber{"trial.object.stiffness_n_per_mm", 0.6, 10,
                "calibrated: 14 % broken with force. Contacts of prosthetic fingers have 0.06 to 0.64 N/mm, "
                "a brittle "
                "cracker between hard fingertips 10 N/mm and more",
                [](Scene& s) -> double& { return trial_of(s).object.stiffness_n_per_mm; }},
    TrialNumber{
        "trial.user.aim_n", 4, 14,
        "calibrated: 27.5 % broken without feedback. From half the least breaking force to above its median",
        [](Scene& s) -> double& { return trial_of(s).user.aim_n; }},
    TrialNumber{
        "gain.lambda_n", 1, 10,
        "assumed: the paper does not give it. From a gain that falls to 1/e in 1 N to one that does in 10 N",
        [](Scene& s) -> double& { return s.gain.lambda_n; }},
    TrialNumber{"gain.onset_n", 0, 4, "assumed: the paper does not give the force at which its decay begins",
                [](Scene& s) -> double& { return s.gain.onset_n; }},
    TrialNumber{"gain.limit_n", 8, 14, "assumed: where the gain is 0",
                [](Scene& s) -> double& { return s.gain.limit_n; }},
    TrialNumber{"trial.user.aim_spread", 0.1, 0.4,
                "assumed: a force that is produced without feeling it varies by 10 to 40 %",
                [](Scene& s) -> double& { return trial_of(s).user.aim_spread; }},
    TrialNumber{"trial.user.user_spread", 0, 0.3, assumed,
                [](Scene& s) -> double& { return trial_of(s).user.user_spread; }},
    TrialNumber{"trial.user.reach_effort", 0.25, 0.4, "assumed: users approach a delicate object gently",
                [](Scene& s) -> double& { return trial_of(s).user.reach_effort; }},
    TrialNumber{"trial.user.reach_spread", 0.1, 0.4, assumed,
                [](Scene& s) -> double& { return trial_of(s).user.reach_spread; }},
    TrialNumber{
        "trial.user.reaction_ms", 150, 300,
        "simple visual reactions: 200 to 250 ms in the mean (Woods et al., Front. Hum. Neurosci. 2015)",
        [](Scene& s) -> double& { return trial_of(s).user.reaction_ms; }},
    TrialNumber{"trial.user.reaction_spread", 0, 0.3, assumed,
                [](Scene& s) -> double& { return trial_of(s).user.reaction_spread; }},
    TrialNumber{"trial.user.delay_ms", 30, 100,
                "electromechanical delay: 30 to 100 ms (Cavanagh and Komi, Eur. J. Appl. Physiol. 1979)",
                [](Scene& s) -> double& { return trial_of(s).user.delay_ms; }},
    TrialNumber{"trial.user.contraction_ms", 30, 150, assumed,
                [](Scene& s) -> double& { return trial_of(s).user.contraction_ms; }},
    TrialNumber{"trial.user.grip_s", 0.3, 1.2, assumed,
                [](Scene& s) -> double& { return trial_of(s).user.grip_s; }},
    TrialNumber{"trial.user.press_on", 0, 1,
                "assumed: up to twice the effort in a hand that does not answer at all",
                [](Scene& s) -> double& { return trial_of(s).user.press_on; }},
    TrialNumber{
        "trial.emg.bandwidth_hz", 50, 120,
        "chosen: the amplitude then varies by 16 to 20 % in a window of 60 ms and by 9 % in one of 200 ms",
        [](Scene& s) -> double& { return trial_of(s).emg.bandwidth_hz; }},
    TrialNumber{"trial.emg.rest_effort", 0.02, 0.08, "about 5 % of the strongest contraction",
                [](Scene& s) -> double& { return trial_of(s).emg.rest_effort; }},
    TrialNumber{"hand.envelope_ms", 20, 100, assumed, [](Scene& s) -> double& { return s.hand.envelope_ms; }},
    TrialNumber{"trial.motor.closing_s", 0.5, 1, "bebionic hand (RSLSteeper, technical manual)",
                [](Scene& s) -> double& { return trial_of(s).motor.closing_s; }},
    TrialNumber{
        "trial.motor.force_limit_n", 20, 140,
        "bebionic hand: 26.5 N in the lateral grip, 140 N in the power grip (RSLSteeper, technical manual)",
        [](Scene& s) -> double& { return trial_of(s).motor.force_limit_n; }},
    TrialNumber{"trial.motor.time_constant_ms", 20, 80, assumed,
                [](Scene& s) -> double& { return trial_of(s).motor.time_constant_ms; }},
    TrialNumber{"trial.motor.dead_band", 0.05, 0.12, "assumed: above what the electrode reads at rest",
                [](Scene& s) -> double& { return trial_of(s).motor.dead_band; }},
    TrialNumber{"trial.object.stiffness_spread", 0.3, 0.9, assumed,
                [](Scene& s) -> double& { return trial_of(s).object.stiffness_spread; }},
    TrialNumber{"trial.object.breaking_force_n", 10, 16, "assumed: the paper's objects break above 8 N",
                [](Scene& s) -> double& { return trial_of(s).object.breaking_force_n; }},
    TrialNumber{"trial.object.breaking_spread", 0.2, 0.45, "real fragile objects: 20 to 45 %",
                [](Scene& s) -> double& { return trial_of(s).object.breaking_spread; }},
    TrialNumber{"trial.object.weight_n", 0.05, 0.5, assumed,
                [](Scene& s) -> double& { return trial_of(s).object.weight_n; }},
    TrialNumber{"trial.object.friction", 0.3, 1, assumed,
                [](Scene& s) -> double& { return trial_of(s).object.friction; }},
    TrialNumber{"trial.object.distance_mm", 15, 60, assumed,
                [](Scene& s) -> double& { return trial_of(s).object.distance_mm; }},
    TrialNumber{"trial.sensing.gain_spread", 0, 0.1, "assumed: elements calibrated to 10 %",
                [](Scene& s) -> double& { return trial_of(s).sensing.gain_spread; }},
    TrialNumber{"trial.sensing.common_gain_spread", 0, 0.1, "assumed: a hand calibrated to 10 %",
                [](Scene& s) -> double& { return trial_of(s).sensing.common_gain_spread; }},
    TrialNumber{"trial.sensing.share_spread", 0, 0.5,
                "assumed: objects that touch other elements than the scene says",
                [](Scene& s) -> double& { return trial_of(s).sensing.share_spread; }},
    TrialNumber{"trial.connection_interval_ms", 10, 100,
                "the paper's Bluetooth hop takes one to two connection intervals, which it does not give",
                [](Scene& s) -> double& { return trial_of(s).connection_interval_ms; }},
    TrialNumber{"link.channel.latency_ms", 0, 40, "assumed: none beyond the radio's connections",
                [](Scene& s) -> double& { return channel_of(s).latency_ms; }},
    TrialNumber{"link.channel.loss", 0, 0.1, "assumed: none",
                [](Scene& s) -> double& { return channel_of(s).loss; }},
};

}  // namespace

std::span<const TrialNumber> trial_numbers() noexcept { return numbers; }

const TrialNumber* find_trial_number(std::string_view path) noexcept {
    const auto found = std::ranges::find(numbers, path, &TrialNumber::path);
    return found == numbers.end() ? nullptr : &*found;
}

Scene with_number(const Scene& scene, const TrialNumber& number, double value) {
    Scene changed = scene;
    number.in(changed) = value;
    if (!changed.trial || !number.path.starts_with("gain.")) return changed;
    Scene of_condition = scene;
    for (scene::TrialCondition& condition : changed.trial->conditions) {
        if (!condition.gain) continue;
        of_condition.gain = *condition.gain;
        number.in(of_condition) = value;
        condition.gain = of_condition.gain;
    }
    return changed;
}

double value_in(const Scene& scene, const TrialNumber& number) {
    Scene copy = scene;
    return number.in(copy);
}

}  // namespace afferent
