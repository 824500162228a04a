// What leaves a running scene for the world.
#pragma once

#include <cstddef>
#include <string>
#include <variant>

#include "afferent/scene/fields.hpp"

namespace afferent {

namespace scene {

// Commands as a table in a file.
struct CommandFile {
    static constexpr const char* alternative = "command_file";
    std::string path = {};
    bool operator==(const CommandFile&) const = default;
    static void fields(auto& self, auto&& f) { f("path", self.path); }
};

// What an estimate drives besides the gain.
using Output = std::variant<CommandFile>;

}  // namespace scene

struct Plan;
class PlanItems;
class SceneFaults;

// Of the index-th output.
void check(const scene::Output& output, std::size_t index, SceneFaults& faults);
void add_output_items(const Plan& plan, PlanItems& items);

}  // namespace afferent
