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
    std::string path = {};
    bool operator==(const CommandFile&) const = default;
    static void fields(auto& self, auto&& f) { f("path", self.path); }
};

// Sends address events to another program on this machine.
struct LiveEvents {
    static constexpr const char* alternative = "live_events";
    std::string host = "127.0.0.1";
    std::uint32_t port = 8991;
    std::string path = {};  // of a Unix socket; empty: host and port
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

// Whether the output takes steps, and so requires a controller.
bool takes_steps(const scene::Output& output);
// Whether the output takes events.
bool takes_events(const scene::Output& output);

// Checks the index-th output.
void check(const scene::Output& output, std::size_t index, SceneFaults& faults);
void add_output_items(const Plan& plan, PlanItems& items);

}  // namespace afferent
