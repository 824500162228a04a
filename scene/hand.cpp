#include "afferent/scene/hand.hpp"

#include "afferent/scene/plan.hpp"
#include "afferent/scene/scene_faults.hpp"

namespace afferent {

Gripper::Parameters gripper_parameters(const scene::Hand& hand) {
    return {.time_constant_ms = hand.motor.time_constant_ms,
            .speed_mm_per_s = hand.motor.speed_mm_per_s,
            .force_limit_n = hand.motor.force_limit_n,
            .dead_band = hand.motor.dead_band,
            .stiffness_n_per_mm = hand.object.stiffness_n_per_mm,
            .distance_mm = hand.object.distance_mm};
}

void check(const scene::Hand& hand, SceneFaults& faults) {
    faults.check("hand", "", [&] {
        if (hand.emg_table) require_path(hand.emg_table->path, "emg_table.path", "the path of a table");
    });
}

void add_hand_items(const Plan& plan, PlanItems& items) {
    items.add("simulated motor and object", plan.gripper.has_value(),
              plan.gripper ? "the samples are of the simulated hand"
                           : "open loop: the samples come from elsewhere");
    const bool table = plan.scene.hand.emg_table.has_value();
    items.add("simulated user", plan.controller && !table,
              table             ? "the EMG is a table"
              : plan.controller ? "there is no EMG table"
                                : "nobody reads the EMG");
}

}  // namespace afferent
