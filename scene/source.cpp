#include "afferent/scene/source.hpp"

#include <algorithm>

#include "afferent/runtime/parameter_error.hpp"
#include "afferent/runtime/piecewise_linear.hpp"
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

SourceTraits traits_of(const scene::Source& source) {
    using From = SamplesFrom;
    return std::visit(
        Overloaded{
            [](const scene::SimulatedHand&) { return SourceTraits{.from = From::hand, .clocked = true}; },
            [](const scene::Profile&) { return SourceTraits{.from = From::coprocessor, .clocked = true}; },
            [](const scene::Table&) { return SourceTraits{.from = From::coprocessor, .measured = true}; },
            [](const scene::StandardInput&) {
                return SourceTraits{.from = From::coprocessor, .measured = true, .once = true};
            },
            [](const scene::LinkSource&) { return SourceTraits{.from = From::hand, .measured = true}; },
            [](const scene::Pushed&) { return SourceTraits{.from = From::program, .once = true}; },
            [](const scene::HandSensors&) {
                return SourceTraits{.from = From::hand, .measured = true, .once = true};
            },
            [](const scene::Chip& chip) {
                return SourceTraits{
                    .from = From::coprocessor, .measured = true, .once = true, .emulated = chip.compare};
            },
            [](const scene::Touch&) { return SourceTraits{.from = From::coprocessor, .clocked = true}; }},
        source);
}

bool states_grip(const scene::Source& source) { return stated_grip_n(source, scene_start).has_value(); }

std::optional<double> stated_grip_n(const scene::Source& source, TimePoint time) {
    const auto force_n = [&](const std::vector<scene::ProfilePoint>& points) {
        return interpolate(points, &scene::ProfilePoint::time_s, &scene::ProfilePoint::force_n,
                           seconds(time));
    };
    if (const auto* profile = std::get_if<scene::Profile>(&source)) return force_n(profile->point);
    const scene::Touch* const touch = touch_of(source);
    if (!touch || touch->grasp.empty()) return std::nullopt;
    double sum_n = 0;
    for (const scene::Grasp& grasp : touch->grasp) sum_n += force_n(grasp.point);
    return sum_n;
}

const scene::Touch* touch_of(const scene::Source& source) { return std::get_if<scene::Touch>(&source); }

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
            [](const scene::Pushed&) {},
            [&](const scene::HandSensors&) {
                rule([&] {
                    if (!scene.hand.ability_hand)
                        throw ParameterError("hand_sensors",
                                             "given with hand.ability_hand, whose sensors they are", "alone");
                });
            },
            [&](const scene::Chip& chip) {
                rule([&] {
                    require_path(chip.device, "chip.device", "the path of a serial device");
                    if (!traits_of(scene.link.transport).packets)
                        throw ParameterError("chip", "on a link with packets, as the chip's line has",
                                             "in process");
                    if (!std::ranges::all_of(scene.patches, [](const scene::Patch& patch) {
                            return patch.neuron.fixed_point.has_value();
                        }))
                        throw ParameterError("chip", "where all neurons are fixed_point, as a chip's are",
                                             "with others");
                    if (std::ranges::any_of(
                            scene.patches, [](const scene::Patch& patch) { return patch.nerve.has_value(); }))
                        throw ParameterError("chip", "without a nerve, since its events leave as it fires",
                                             "with one");
                    if (scene.link.bus)
                        throw ParameterError("chip", "without link.bus, since its events are past any bus",
                                             "with it");
                    if (scene.link.encoding == scene::Encoding::predicted)
                        throw ParameterError("chip",
                                             "with link.encoding RICE or FIXED_WIDTH, which chips write",
                                             "with PREDICTED");
                });
            },
            [&](const scene::Touch& touch) { check(touch, scene, faults); }},
        source);
}

void add_source_items(const Plan& plan, PlanItems& items) {
    const scene::Table* const table = force_table(plan.scene.source);
    const bool linear = table && table->between == scene::Between::linear;
    items.add("samples between the rows of a table", linear,
              !table   ? "the samples are no table in a file"
              : linear ? "between is LINEAR: where rows are further apart than samples"
                       : "between is HOLD: a row is held until the next");
    const scene::Touch* const touch = touch_of(plan.scene.source);
    const bool waves = touch && touch->skin.wave && !touch->indenter.empty();
    items.add("waves in the skin", waves,
              !touch              ? "nothing presses skin"
              : !touch->skin.wave ? "source.skin.wave is not given"
              : waves ? "source.skin.wave: all elements within " + decimal(touch->skin.wave->reach_mm) +
                            " mm of an indenter are sampled"
                      : "no indenter sends any");
    const auto* const chip = std::get_if<scene::Chip>(&plan.scene.source);
    items.add("neurons of the emulator", traits_of(plan.scene.source).emulated,
              !chip           ? "the scene's neurons are emulated"
              : chip->compare ? "source.chip.compare: the chip's events are compared with theirs"
                              : "the neurons are the chip's");
}

}  // namespace afferent
