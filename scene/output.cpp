#include "afferent/scene/output.hpp"

#include <algorithm>

#include "afferent/runtime/parameter_error.hpp"
#include "afferent/scene/plan.hpp"
#include "afferent/scene/scene_faults.hpp"

namespace afferent {

void scene::CommandFile::check() const { require_path(path, "command_file.path", "the path of a file"); }

void scene::LiveEvents::check() const {
    const LiveEvents absent;
    if (!path.empty() && (host != absent.host || port != absent.port))
        throw ParameterError("live_events.path", "absent where host or port is given", "\"" + path + "\"");
}

bool takes_steps(const scene::Output& output) {
    return std::visit([](const auto& one) { return one.takes_steps; }, output);
}

bool takes_events(const scene::Output& output) {
    return std::visit([](const auto& one) { return one.takes_events; }, output);
}

void check(const scene::Output& output, std::size_t index, SceneFaults& faults) {
    faults.check("output[" + std::to_string(index) + "]", "",
                 [&] { std::visit([](const auto& one) { one.check(); }, output); });
}

void add_output_items(const Plan& plan, PlanItems& items) {
    const std::vector<scene::Output>& outputs = plan.scene.output;
    if (std::ranges::none_of(outputs, takes_steps))
        items.add(scene::CommandFile::item, false,
                  outputs.empty() ? "output is not given" : "output.command_file is not given");
    for (const scene::Output& output : outputs)
        std::visit([&](const auto& one) { items.add(one.item, true, one.reason()); }, output);
}

}  // namespace afferent
