// The hand of a scene: EMG, motor, object, and safe state. Included with scene.hpp by whoever builds a scene.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "afferent/hand/user.hpp"
#include "afferent/runtime/grip_state.hpp"
#include "afferent/scene/source.hpp"

namespace afferent {

void each_field(Is<User::Parameters> auto& user, auto&& f) {
    f(within("close_at_s", 0, 1e9), user.close_at_s);
    f(within("close_for_s", 0, 1e9), user.close_for_s);
    f(within("hold_for_s", 0, 1e9), user.hold_for_s);
    f(within("open_for_s", 0, 1e9), user.open_for_s);
    f(within("effort", 0, 1), user.effort);
    f(above("ramp_s", 0, 1e9), user.ramp_s);
    f(within("hold_effort", 0, 1), user.hold_effort);
}

namespace scene {

enum class EmgUnit { by_name, counts, volts };
enum class EmgSignal { automatic, raw, envelope };

struct EmgTable {
    std::string path = {};
    std::string column = "emg";
    std::optional<double> rest_counts = {};
    double full_scale_counts = 500;
    Between between = Between::linear;
    std::string time_column = {};
    TimeUnit time_unit = TimeUnit::found;
    std::optional<double> rate_hz = {};
    std::optional<double> begin_s = {};
    EmgUnit unit = EmgUnit::by_name;
    EmgSignal signal = EmgSignal::automatic;
    std::optional<double> full_scale_v = {};  // absent: found from the recording
    Missing missing = Missing::refuse;
    bool operator==(const EmgTable&) const = default;
    static void fields(auto& self, auto&& f) {
        f("path", self.path);
        f("column", self.column);
        f(within("rest_counts", -1e9, 1e9), self.rest_counts);
        f(above("full_scale_counts", 0, 1e9), self.full_scale_counts);
        f("between", self.between);
        f("time_column", self.time_column);
        f("time_unit", self.time_unit);
        f(within("rate_hz", 0.001, 1e6), self.rate_hz);
        f(within("begin_s", -9e9, 9e9), self.begin_s);
        f("unit", self.unit);
        f("signal", self.signal);
        f(above("full_scale_v", 0, 1e6), self.full_scale_v);
        f("missing", self.missing);
    }
};

struct Motor {
    double time_constant_ms = 60;
    double speed_mm_per_s = 60;
    double force_limit_n = 25;
    double dead_band = 0.02;
    bool operator==(const Motor&) const = default;
    static void fields(auto& self, auto&& f) {
        f(above("time_constant_ms", 0, 1e6), self.time_constant_ms);
        f(above("speed_mm_per_s", 0, 1e6), self.speed_mm_per_s);
        f(above("force_limit_n", 0, 1e6), self.force_limit_n);
        f(below("dead_band", 0, 1), self.dead_band);
    }
};

struct Object {
    double stiffness_n_per_mm = 0.6;
    double distance_mm = 20;
    bool operator==(const Object&) const = default;
    static void fields(auto& self, auto&& f) {
        f(above("stiffness_n_per_mm", 0, 1e6), self.stiffness_n_per_mm);
        f(within("distance_mm", 0, 1e6), self.distance_mm);
    }
};

// How the flexors of a hand on a line follow the command.
struct PositionDrive {
    static constexpr const char* alternative = "position";
    double speed_deg_per_s = 120;
    double lead_deg = 5;
    bool operator==(const PositionDrive&) const = default;
    static void fields(auto& self, auto&& f) {
        f(above("speed_deg_per_s", 0, 1000), self.speed_deg_per_s);
        f(above("lead_deg", 0, 150), self.lead_deg);
    }
};
struct VelocityDrive {
    static constexpr const char* alternative = "velocity";
    double speed_deg_per_s = 40;
    bool operator==(const VelocityDrive&) const = default;
    static void fields(auto& self, auto&& f) { f(above("speed_deg_per_s", 0, 3000), self.speed_deg_per_s); }
};
struct CurrentDrive {
    static constexpr const char* alternative = "current";
    double current_a = 0.4;
    bool operator==(const CurrentDrive&) const = default;
    static void fields(auto& self, auto&& f) { f(above("current_a", 0, 10), self.current_a); }
};
struct DutyDrive {
    static constexpr const char* alternative = "duty";
    double duty_percent = 50;
    bool operator==(const DutyDrive&) const = default;
    static void fields(auto& self, auto&& f) { f(above("duty_percent", 0, 100), self.duty_percent); }
};
using FingerDrive = std::variant<PositionDrive, VelocityDrive, CurrentDrive, DutyDrive>;

struct AbilityHand {
    std::string port = {};
    std::uint32_t baud = 921600;
    std::uint32_t address = 80;
    double rate_hz = 500;
    FingerDrive drive = {};
    double open_deg = 5;
    double close_deg = 100;
    double thumb_rotation_deg = -80;
    std::vector<double> zero_counts = {};  // empty: all 0
    double zero_drift_n = 0.3;
    bool operator==(const AbilityHand&) const = default;
    static void fields(auto& self, auto&& f) {
        f("port", self.port);
        f(within("baud", 9600, 4e6), self.baud);
        f(within("address", 0, 255), self.address);
        f(within("rate_hz", 10, 2000), self.rate_hz);
        f.arms(self.drive);
        f(within("open_deg", 0, 150), self.open_deg);
        f(within("close_deg", 0, 150), self.close_deg);
        f(within("thumb_rotation_deg", -150, 0), self.thumb_rotation_deg);
        f(within("zero_counts", 0, 4000), self.zero_counts);
        f(within("zero_drift_n", 0, 100), self.zero_drift_n);
    }
};

struct Hand {
    double emg_rate_hz = 1000;
    double envelope_ms = 40;
    User::Parameters user = {};
    std::optional<EmgTable> emg_table = {};
    Motor motor = {};
    Object object = {};
    SafeState safe_state = SafeState::hold;
    Rearm rearm = Rearm::new_session;
    std::optional<AbilityHand> ability_hand = {};
    bool operator==(const Hand&) const = default;
    static void fields(auto& self, auto&& f) {
        f(within("emg_rate_hz", 1, 100000), self.emg_rate_hz);
        f(above("envelope_ms", 0, 1e6), self.envelope_ms);
        f("user", self.user);
        f("emg_table", self.emg_table);
        f("motor", self.motor);
        f("object", self.object);
        f("safe_state", self.safe_state);
        f("rearm", self.rearm);
        f("ability_hand", self.ability_hand);
    }
};

}  // namespace scene

struct Plan;
class PlanItems;
class SceneFaults;

void check(const scene::Hand& hand, SceneFaults& faults);
// That a hand on a line and the scene's patches and source are of each other.
void check_hand_sensors(const Plan& plan, SceneFaults& faults);
void add_hand_items(const Plan& plan, PlanItems& items);

}  // namespace afferent
