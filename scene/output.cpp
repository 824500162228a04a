#include "afferent/scene/output.hpp"

#include "afferent/runtime/parameter_error.hpp"
#include "afferent/scene/plan.hpp"
#include "afferent/scene/scene_faults.hpp"

namespace afferent {

bool takes_steps(const scene::Output& output) {
    return std::visit(Overloaded{[](const scene::CommandFile&) { return true; },
                                 [](const scene::LiveEvents&) { return false; }},
                      output);
}

bool takes_events(const scene::Output& output) {
    return std::visit(Overloaded{[](const scene::CommandFile&) { return false; },
                                 [](const scene::LiveEvents&) { return true; }},
                      output);
}

void check(const scene::Output& output, std::size_t index, SceneFaults& faults) {
    const Overloaded rules{[](const scene::CommandFile& file) {
                               require_path(file.path, "command_file.path", "the path of a file");
                           },
                           [](const scene::LiveEvents& live) {
                               if (!live.path.empty() && live != scene::LiveEvents{.path = live.path})
                                   throw ParameterError("live_events.path",
                                                        "absent where host or port is given",
                                                        "\"" + live.path + "\"");
                           }};
    faults.check("output[" + std::to_string(index) + "]", "", [&] { std::visit(rules, output); });
}

void add_output_items(const Plan& plan, PlanItems& items) {
    std::size_t files = 0;
    std::string live;
    for (const scene::Output& output : plan.scene.output)
        std::visit(Overloaded{[&](const scene::CommandFile&) { ++files; },
                              [&](const scene::LiveEvents& to) {
                                  live +=
                                      (live.empty() ? "" : ", ") +
                                      (to.path.empty() ? to.host + ":" + std::to_string(to.port) : to.path);
                              }},
                   output);
    items.add("commands in a file", files > 0,
              files > 0                   ? "output.command_file"
              : plan.scene.output.empty() ? "output is not given"
                                          : "output.command_file is not given");
    if (!live.empty()) items.add("live events", true, "output.live_events: to " + live);
}

}  // namespace afferent
