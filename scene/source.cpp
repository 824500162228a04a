#include "afferent/scene/source.hpp"

#include "afferent/runtime/parameter_error.hpp"
#include "afferent/scene/plan.hpp"
#include "afferent/scene/scene_faults.hpp"

namespace afferent {
namespace {

void check_table(const scene::Table& table, const std::string& field) {
    require_path(table.path, (field + ".path").c_str(), "the path of a table");
    if (table.rate_hz && !table.time_column.empty())
        throw ParameterError(field + ".rate_hz", "absent where time_column is given", *table.rate_hz);
}

}  // namespace

SamplesFrom samples_from(const scene::Source& source) {
    return std::visit(Overloaded{[](const scene::SimulatedHand&) { return SamplesFrom::hand; },
                                 [](const scene::Profile&) { return SamplesFrom::coprocessor; },
                                 [](const scene::Table&) { return SamplesFrom::coprocessor; },
                                 [](const scene::StandardInput&) { return SamplesFrom::coprocessor; },
                                 [](const scene::LinkSource&) { return SamplesFrom::hand; },
                                 [](const scene::Pushed&) { return SamplesFrom::program; },
                                 [](const scene::Touch&) { return SamplesFrom::coprocessor; }},
                      source);
}

bool is_clocked(const scene::Source& source) {
    return std::visit(
        Overloaded{[](const scene::SimulatedHand&) { return true; },
                   [](const scene::Profile&) { return true; }, [](const scene::Table&) { return false; },
                   [](const scene::StandardInput&) { return false; },
                   [](const scene::LinkSource&) { return false; }, [](const scene::Pushed&) { return false; },
                   [](const scene::Touch&) { return true; }},
        source);
}

scene::Table* force_table(scene::Source& source) {
    if (auto* const link = std::get_if<scene::LinkSource>(&source)) return &link->table;
    return std::get_if<scene::Table>(&source);
}

const scene::Table* force_table(const scene::Source& source) {
    if (const auto* const link = std::get_if<scene::LinkSource>(&source)) return &link->table;
    return std::get_if<scene::Table>(&source);
}

void check(const scene::Source& source, const Scene& scene, SceneFaults& faults) {
    const auto rule = [&](auto&& body) { faults.check("source", "", body); };
    std::visit(
        Overloaded{
            [](const scene::SimulatedHand&) {},
            [&](const scene::Profile& profile) {
                rule([&] { check_points(profile.point, "profile.point"); });
            },
            [&](const scene::Table& table) { rule([&] { check_table(table, "table"); }); },
            [](const scene::StandardInput&) {},
            [&](const scene::LinkSource& link) { rule([&] { check_table(link.table, "link.table"); }); },
            [](const scene::Pushed&) {}, [&](const scene::Touch& touch) { check(touch, scene, faults); }},
        source);
}

void add_source_items(const Plan& plan, PlanItems& items) {
    const scene::Table* const table = force_table(plan.scene.source);
    const bool linear = table && table->between == scene::Between::linear;
    items.add("samples between the rows of a table", linear,
              !table   ? "the samples are no table in a file"
              : linear ? "between is LINEAR: where rows are further apart than samples"
                       : "between is HOLD: a row is held until the next");
}

}  // namespace afferent
