// What leaves a running scene for the world.
#pragma once

#include <cstddef>
#include <cstdint>
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

// Address events to another program on this machine.
struct LiveEvents {
    static constexpr const char* alternative = "live_events";
    std::string host = "127.0.0.1";
    std::uint32_t port = 8991;
    std::string path = {};  // empty: host and port
    bool operator==(const LiveEvents&) const = default;
    static void fields(auto& self, auto&& f) {
        f("host", self.host);
        f(within("port", 1, 65535), self.port);
        f("path", self.path);
    }
};

using Output = std::variant<CommandFile, LiveEvents>;

}  // namespace scene

struct Plan;
class PlanItems;
class SceneFaults;

// Whether it takes steps of a controller, so that there has to be one.
bool takes_steps(const scene::Output& output);

// Of the index-th output.
void check(const scene::Output& output, std::size_t index, SceneFaults& faults);
void add_output_items(const Plan& plan, PlanItems& items);

}  // namespace afferent
