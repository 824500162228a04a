#include "afferent/scene/output.hpp"

#include "afferent/scene/plan.hpp"
#include "afferent/scene/scene_faults.hpp"

namespace afferent {

void check(const scene::Output& output, std::size_t index, SceneFaults& faults) {
    const Overloaded rules{[](const scene::CommandFile& file) {
        require_path(file.path, "command_file.path", "the path of a file");
    }};
    faults.check("output[" + std::to_string(index) + "]", "", [&] { std::visit(rules, output); });
}

void add_output_items(const Plan& plan, PlanItems& items) {
    const auto& outputs = plan.scene.output;
    items.add("commands in a file", !outputs.empty(),
              outputs.empty() ? "output is not given" : "output.command_file");
}

}  // namespace afferent
