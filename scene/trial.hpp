// The trial of a scene: users and objects of the experiment. Included with scene.hpp by whoever builds a
// scene.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "afferent/hand/prosthesis_motor.hpp"
#include "afferent/hand/surface_emg.hpp"
#include "afferent/hand/trial_object.hpp"
#include "afferent/hand/trial_user.hpp"
#include "afferent/scene/decoder.hpp"
#include "afferent/scene/fields.hpp"

namespace afferent {

void each_field(Is<TrialUser::Parameters> auto& user, auto&& f) {
    f(within("users", 1, 1e6), user.users);
    f(within("begin_s", 0, 100), user.begin_s);
    f(above("reach_effort", 0, 1), user.reach_effort);
    f(within("reach_spread", 0, 2), user.reach_spread);
    f(above("aim_n", 0, 1000), user.aim_n);
    f(within("aim_spread", 0, 2), user.aim_spread);
    f(within("user_spread", 0, 2), user.user_spread);
    f(within("reaction_ms", 0, 5000), user.reaction_ms);
    f(within("reaction_spread", 0, 2), user.reaction_spread);
    f(within("delay_ms", 0, 1000), user.delay_ms);
    f(above("contraction_ms", 0, 10000), user.contraction_ms);
    f(within("grip_s", 0, 100), user.grip_s);
    f(above("lift_s", 0, 100), user.lift_s);
    f(above("lift_mm_per_s", 0, 10000), user.lift_mm_per_s);
    f(within("settle_s", 0, 100), user.settle_s);
    f(within("hold_s", 0, 100), user.hold_s);
    f(within("slip_effort", 1, 100), user.slip_effort);
    f(above("patience_s", 0, 100), user.patience_s);
    f(within("press_on", 0, 10), user.press_on);
}

void each_field(Is<SurfaceEmg::Parameters> auto& emg, auto&& f) {
    f(above("centre_hz", 0, 50000), emg.centre_hz);
    f(above("bandwidth_hz", 0, 50000), emg.bandwidth_hz);
    f(within("rest_effort", 0, 1), emg.rest_effort);
}

void each_field(Is<ProsthesisMotor::Parameters> auto& motor, auto&& f) {
    f(above("aperture_mm", 0, 1e4), motor.aperture_mm);
    f(above("closing_s", 0, 100), motor.closing_s);
    f(above("force_limit_n", 0, 1e4), motor.force_limit_n);
    f(above("time_constant_ms", 0, 1e4), motor.time_constant_ms);
    f(below("dead_band", 0, 1), motor.dead_band);
}

void each_field(Is<TrialObjects::Delicate> auto& object, auto&& f) {
    f(above("stiffness_n_per_mm", 0, 1e4), object.stiffness_n_per_mm);
    f(within("stiffness_spread", 0, 2), object.stiffness_spread);
    f(above("breaking_force_n", 0, 1e4), object.breaking_force_n);
    f(within("breaking_spread", 0, 2), object.breaking_spread);
    f(within("least_breaking_force_n", 0, 1e4), object.least_breaking_force_n);
    f(above("weight_n", 0, 1e4), object.weight_n);
    f(above("friction", 0, 100), object.friction);
    f(within("distance_mm", 0, 1e4), object.distance_mm);
    f(within("distance_spread", 0, 2), object.distance_spread);
}

void each_field(Is<TrialObjects::Slippery> auto& object, auto&& f) {
    f(within("part", 0, 1), object.part);
    f(above("stiffness_n_per_mm", 0, 1e4), object.stiffness_n_per_mm);
    f(within("stiffness_spread", 0, 2), object.stiffness_spread);
    f(above("weight_n", 0, 1e4), object.weight_n);
    f(within("weight_spread", 0, 2), object.weight_spread);
    f(above("friction", 0, 100), object.friction);
    f(within("taper", 0, 1), object.taper);
    f(within("distance_mm", 0, 1e4), object.distance_mm);
    f(within("distance_spread", 0, 2), object.distance_spread);
    f(above("aim_factor", 0, 100), object.aim_factor);
}

namespace scene {

struct SendOnDelta {
    double delta_n = 0.1;
    double time_constant_ms = 20;
    double threshold_events = 2;
    bool operator==(const SendOnDelta&) const = default;
    static void fields(auto& self, auto&& f) {
        f(above("delta_n", 0, 1000), self.delta_n);
        f(above("time_constant_ms", 0, 10000), self.time_constant_ms);
        f(above("threshold_events", 0, 1e6), self.threshold_events);
    }
};

struct TrialSensing {
    double gain_spread = 0;
    double common_gain_spread = 0;
    double share_spread = 0;
    std::uint32_t dead_elements = 0;
    bool operator==(const TrialSensing&) const = default;
    static void fields(auto& self, auto&& f) {
        f(within("gain_spread", 0, 2), self.gain_spread);
        f(within("common_gain_spread", 0, 2), self.common_gain_spread);
        f(within("share_spread", 0, 2), self.share_spread);
        f(within("dead_elements", 0, most_addresses), self.dead_elements);
    }
};

struct TrialCondition {
    std::string name = {};
    std::optional<Gain> gain = {};
    bool operator==(const TrialCondition&) const = default;
    static void fields(auto& self, auto&& f) {
        f("name", self.name);
        f("gain", self.gain);
    }
};

struct Trial {
    TrialUser::Parameters user = {};
    SurfaceEmg::Parameters emg = {};
    ProsthesisMotor::Parameters motor = {};
    TrialObjects::Delicate object = {};
    TrialObjects::Slippery slippery = {};
    double connection_interval_ms = 30;
    SendOnDelta send_on_delta = {};
    std::vector<TrialCondition> conditions = {};
    TrialSensing sensing = {};
    bool untimed_events = false;
    bool operator==(const Trial&) const = default;
    static void fields(auto& self, auto&& f) {
        f("user", self.user);
        f("emg", self.emg);
        f("motor", self.motor);
        f("object", self.object);
        f("slippery", self.slippery);
        f(within("connection_interval_ms", 0, 1000), self.connection_interval_ms);
        f("send_on_delta", self.send_on_delta);
        f("condition", self.conditions);
        f("sensing", self.sensing);
        f("untimed_events", self.untimed_events);
    }
};

}  // namespace scene

struct Scene;
class SceneFaults;

void check(const scene::Trial& trial, const Scene& scene, SceneFaults& faults);

}  // namespace afferent
