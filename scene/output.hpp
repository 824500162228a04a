// The outputs of a running scene. Included with scene.hpp by whoever builds a scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>

#include "afferent/scene/fields.hpp"

namespace afferent {

namespace scene {

// Writes commands as a table to a file.
struct CommandFile {
    static constexpr const char* alternative = "command_file";
    static constexpr const char* item = "commands in a file";
    static constexpr bool takes_steps = true;
    static constexpr bool takes_events = false;
    std::string path = {};
    bool operator==(const CommandFile&) const = default;
    static void fields(auto& self, auto&& f) { f("path", self.path); }
    void check() const;
    std::string reason() const { return "output.command_file"; }
};

// Sends address events to another program on this machine.
struct LiveEvents {
    static constexpr const char* alternative = "live_events";
    static constexpr const char* item = "live events";
    static constexpr bool takes_steps = false;
    static constexpr bool takes_events = true;
    std::string host = "127.0.0.1";
    std::uint32_t port = 8991;
    std::string path = {};  // of a Unix socket; empty: host and port
    bool operator==(const LiveEvents&) const = default;
    static void fields(auto& self, auto&& f) {
        f("host", self.host);
        f(within("port", 1, 65535), self.port);
        f("path", self.path);
    }
    void check() const;
    std::string reason() const {
        return "output.live_events: to " + (path.empty() ? host + ":" + std::to_string(port) : path);
    }
};

// Each says what it takes (steps only a controller has), checks itself, and has an item of the plan with the
// reason why it is built.
using Output = std::variant<CommandFile, LiveEvents>;

}  // namespace scene

struct Plan;
class PlanItems;
class SceneFaults;

bool takes_steps(const scene::Output& output);
bool takes_events(const scene::Output& output);

// Checks the index-th output.
void check(const scene::Output& output, std::size_t index, SceneFaults& faults);
void add_output_items(const Plan& plan, PlanItems& items);

}  // namespace afferent
