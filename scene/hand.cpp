#include "afferent/scene/hand.hpp"

#include <algorithm>

#include "afferent/hand/ability_hand.hpp"
#include "afferent/runtime/overloaded.hpp"
#include "afferent/scene/plan.hpp"
#include "afferent/scene/scene_faults.hpp"

namespace afferent {
namespace {

void check_ability_hand(const scene::AbilityHand& hand) {
    require_path(hand.port, "ability_hand.port", "the path of a serial device");
    require(hand.open_deg < hand.close_deg, "ability_hand.open_deg", "< close_deg", hand.open_deg);
    const std::size_t zeros = hand.zero_counts.size();
    if (zeros != 0 && zeros != ability_hand::sensors)
        throw ParameterError("ability_hand.zero_counts",
                             "one for each of the " + std::to_string(ability_hand::sensors) + " sensors",
                             std::to_string(zeros) + " of them");
}

// What the hand goes on doing until it leaves its mode, when no command comes any more.
std::string left_by_a_cut_cable(const scene::FingerDrive& drive) {
    const auto goes_on = [](const std::string& what) {
        return "goes on for " + decimal(Milliseconds(ability_hand::leaves_mode_after).count()) + " ms with " +
               what;
    };
    return std::visit(
        Overloaded{[](const scene::PositionDrive&) { return std::string("stops at its last targets"); },
                   [&](const scene::VelocityDrive& velocity) {
                       return goes_on(
                           "its last velocity, up to " +
                           decimal(velocity.speed_deg_per_s * seconds(ability_hand::leaves_mode_after)) +
                           " degrees");
                   },
                   [&](const scene::CurrentDrive& current) {
                       return goes_on("its last current, up to " + decimal(current.current_a) + " A");
                   },
                   [&](const scene::DutyDrive& duty) {
                       return goes_on("its last duty cycle, up to " + decimal(duty.duty_percent) + " %");
                   }},
        drive);
}

}  // namespace

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
        if (hand.ability_hand) check_ability_hand(*hand.ability_hand);
    });
}

void check_hand_sensors(const Plan& plan, SceneFaults& faults) {
    if (!plan.scene.hand.ability_hand) return;
    if (!std::holds_alternative<scene::HandSensors>(plan.scene.source))
        faults.add(
            {"source", "",
             "source must be hand_sensors {} where hand.ability_hand is given: a hand closes by what its "
             "own sensors feel"});
    if (plan.elements != ability_hand::sensors)
        faults.add({"patch", "",
                    "patch: the elements of all patches must be the " +
                        std::to_string(ability_hand::sensors) + " sensors of hand.ability_hand, are " +
                        std::to_string(plan.elements)});
}

void add_hand_items(const Plan& plan, PlanItems& items) {
    items.add("simulated motor and object", plan.gripper.has_value(),
              plan.gripper ? "the samples are of the simulated hand"
                           : "open loop: the samples come from elsewhere");
    const auto& real = plan.scene.hand.ability_hand;
    items.add("hand on a serial line", real.has_value(),
              real ? "hand.ability_hand: at most " + decimal(real->rate_hz) + " commands per second on " +
                         real->port + "; when its cable is cut, it " + left_by_a_cut_cable(real->drive)
                   : "no hand.ability_hand");
    const bool table = plan.scene.hand.emg_table.has_value();
    items.add("simulated user", plan.controller && !table,
              table             ? "the EMG is a table"
              : plan.controller ? "there is no EMG table"
                                : "nobody reads the EMG");
}

}  // namespace afferent
