// The source of a scene's samples. Included with scene.hpp by whoever builds a scene.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "afferent/io/files/time_unit.hpp"
#include "afferent/scene/sensor.hpp"
#include "afferent/scene/touch.hpp"

namespace afferent {

namespace scene {

struct SimulatedHand {
    static constexpr const char* alternative = "simulated_hand";
    bool operator==(const SimulatedHand&) const = default;
    static void fields(auto&, auto&&) {}
};

struct Profile {
    static constexpr const char* alternative = "profile";
    std::vector<ProfilePoint> point = {};
    bool operator==(const Profile&) const = default;
    static void fields(auto& self, auto&& f) { f("point", self.point); }
};

// How samples between two rows of a table are computed.
enum class Between { linear, hold };

// The unit of columns whose names state none.
enum class TableUnit { by_name, newtons, counts, volts };

struct Table {
    static constexpr const char* alternative = "table";
    std::string path = {};
    std::vector<std::string> column = {};
    OutOfRange out_of_range = OutOfRange::clip;
    Between between = Between::linear;
    std::string time_column = {};  // empty: found by name
    TimeUnit time_unit = TimeUnit::found;
    std::optional<double> rate_hz = {};  // absent: rows have times
    std::optional<double> begin_s = {};  // absent: the first row's time, if it is 10 s or later
    TableUnit unit = TableUnit::by_name;
    Missing missing = Missing::refuse;
    bool operator==(const Table&) const = default;
    static void fields(auto& self, auto&& f) {
        f("path", self.path);
        f("column", self.column);
        f("out_of_range", self.out_of_range);
        f("between", self.between);
        f("time_column", self.time_column);
        f("time_unit", self.time_unit);
        f(within("rate_hz", 0.001, 1e6), self.rate_hz);
        f(within("begin_s", -9e9, 9e9), self.begin_s);
        f("unit", self.unit);
        f("missing", self.missing);
    }
};

struct StandardInput {
    static constexpr const char* alternative = "standard_input";
    std::vector<std::string> column = {};
    OutOfRange out_of_range = OutOfRange::clip;
    std::string time_column = {};
    TimeUnit time_unit = TimeUnit::found;
    TableUnit unit = TableUnit::by_name;
    Missing missing = Missing::refuse;
    bool operator==(const StandardInput&) const = default;
    static void fields(auto& self, auto&& f) {
        f("column", self.column);
        f("out_of_range", self.out_of_range);
        f("time_column", self.time_column);
        f("time_unit", self.time_unit);
        f("unit", self.unit);
        f("missing", self.missing);
    }
};

struct LinkSource {
    static constexpr const char* alternative = "link";
    Table table = {};
    bool operator==(const LinkSource&) const = default;
    static void fields(auto& self, auto&& f) { f("table", self.table); }
};

// The embedding program pushes scans.
struct Pushed {
    static constexpr const char* alternative = "pushed";
    bool operator==(const Pushed&) const = default;
    static void fields(auto&, auto&&) {}
};

// The sensors of a hand on a line.
struct HandSensors {
    static constexpr const char* alternative = "hand_sensors";
    bool operator==(const HandSensors&) const = default;
    static void fields(auto&, auto&&) {}
};

// The neurons are a chip's, on a line.
struct Chip {
    static constexpr const char* alternative = "chip";
    std::string device = {};
    std::uint32_t baud = 115'200;
    bool compare = false;
    bool operator==(const Chip&) const = default;
    static void fields(auto& self, auto&& f) {
        f("device", self.device);
        f(within("baud", 1200, 4e6), self.baud);
        f("compare", self.compare);
    }
};

using Source =
    std::variant<SimulatedHand, Profile, Table, StandardInput, LinkSource, Pushed, HandSensors, Chip, Touch>;

}  // namespace scene

struct Plan;
struct Scene;
class PlanItems;
class SceneFaults;

// Who has the samples: the hand (simulated, or with a table whose samples cross the link), the coprocessor,
// or the embedding program.
enum class SamplesFrom { hand, coprocessor, program };

// Properties of a source.
struct SourceTraits {
    SamplesFrom from;
    bool clocked = false;   // samples come at the sensors' own rates, and not at times that others choose
    bool measured = false;  // forces that were measured, and not made by this hand
    bool once = false;      // they come once, and cannot be asked for again
    bool emulated = true;   // the neurons are computed here
};
SourceTraits traits_of(const scene::Source& source);

// The grip force at that time, if the scene states it: in a profile, or in grasps.
std::optional<double> stated_grip_n(const scene::Source& source, TimePoint time);
bool states_grip(const scene::Source& source);

void check(const scene::Source& source, const Scene& scene, SceneFaults& faults);
void add_source_items(const Plan& plan, PlanItems& items);

// The table of forces, at either end of the link. Null if the scene has none.
const scene::Table* force_table(const scene::Source& source);
scene::Table* force_table(scene::Source& source);

// The stimuli on the skin. Null if the scene has none.
const scene::Touch* touch_of(const scene::Source& source);

}  // namespace afferent
