// Where the samples of a scene come from.
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

// What there is between two rows of a table that are further apart than its samples are.
enum class Between { linear, hold };

// The unit of columns whose names have none.
enum class TableUnit { by_name, newtons, counts, volts };

struct Table {
    static constexpr const char* alternative = "table";
    std::string path = {};
    std::vector<std::string> column = {};
    OutOfRange out_of_range = OutOfRange::clip;
    Between between = Between::linear;
    std::string time_column = {};  // empty: by its name
    TimeUnit time_unit = TimeUnit::found;
    std::optional<double> rate_hz = {};  // none: rows have times
    std::optional<double> begin_s = {};  // none: the first row's time, where it is 10 s or later
    TableUnit unit = TableUnit::by_name;
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
    }
};

struct StandardInput {
    static constexpr const char* alternative = "standard_input";
    std::vector<std::string> column = {};
    OutOfRange out_of_range = OutOfRange::clip;
    std::string time_column = {};
    TimeUnit time_unit = TimeUnit::found;
    TableUnit unit = TableUnit::by_name;
    bool operator==(const StandardInput&) const = default;
    static void fields(auto& self, auto&& f) {
        f("column", self.column);
        f("out_of_range", self.out_of_range);
        f("time_column", self.time_column);
        f("time_unit", self.time_unit);
        f("unit", self.unit);
    }
};

struct LinkSource {
    static constexpr const char* alternative = "link";
    Table table = {};
    bool operator==(const LinkSource&) const = default;
    static void fields(auto& self, auto&& f) { f("table", self.table); }
};

// The program that embeds the scene pushes scans.
struct Pushed {
    static constexpr const char* alternative = "pushed";
    bool operator==(const Pushed&) const = default;
    static void fields(auto&, auto&&) {}
};

using Source = std::variant<SimulatedHand, Profile, Table, StandardInput, LinkSource, Pushed, Touch>;

}  // namespace scene

struct Plan;
struct Scene;
class PlanItems;
class SceneFaults;

// Where the samples come from: the hand's end of a link (a simulated hand, or a table that crosses the
// link), the coprocessor's, or the program that embeds the scene.
enum class SamplesFrom { hand, coprocessor, program };
SamplesFrom samples_from(const scene::Source& source);

// Whether samples come at the sensors' own rates, and not at times that others choose.
bool is_clocked(const scene::Source& source);

void check(const scene::Source& source, const Scene& scene, SceneFaults& faults);
void add_source_items(const Plan& plan, PlanItems& items);

// The table of forces, at whichever end of the link it is; null: the scene has none.
const scene::Table* force_table(const scene::Source& source);
scene::Table* force_table(scene::Source& source);

}  // namespace afferent
