// A patch: elements with one kind of sensor, and the afferents that read them. Included with scene.hpp by
// whoever builds a scene.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "afferent/scene/afferents.hpp"
#include "afferent/scene/encoder.hpp"
#include "afferent/scene/neuron.hpp"
#include "afferent/scene/sensor.hpp"

namespace afferent {

namespace scene {

// The kinds of afferents of the human hand.
enum class Kind { sa1, ra, pc, sa1_dynamic };

// On which each event takes length / speed.
struct Nerve {
    double length_mm = 450;
    double speed_m_per_s = 55;
    bool operator==(const Nerve&) const = default;
    static void fields(auto& self, auto&& f) {
        f(within("length_mm", 1, 2000), self.length_mm);
        f(within("speed_m_per_s", 1, 150), self.speed_m_per_s);
    }
};

struct Patch {
    std::string name = {};
    std::uint32_t elements = 3;
    // The share of the grip force of each element. Empty: the elements of all such patches divide the rest
    // equally.
    std::vector<double> share = {};
    // If given, the patch reads the elements of the patch with this name.
    std::optional<std::string> elements_of = {};
    // One receptive field per afferent. Empty, and no `afferents`: one afferent per element.
    std::vector<Field> field = {};
    // If given, the elements are the cells of a grid within it.
    std::optional<Outline> outline = {};
    std::optional<Afferents> afferents = {};
    Spread spread = {};
    Sensor sensor = {};
    Encoder encoder = {};
    Neuron neuron = {};
    // If all numbers are given: the name of the kind, for people.
    std::optional<Kind> of_kind = {};
    std::optional<Nerve> nerve = {};
    bool operator==(const Patch&) const = default;
    static void fields(auto& self, auto&& f) {
        f("name", self.name);
        f(within("elements", 1, most_addresses), self.elements);
        f(within("share", 0, 1), self.share);
        f("elements_of", self.elements_of);
        f("field", self.field);
        f("outline", self.outline);
        f("afferents", self.afferents);
        f("spread", self.spread);
        f("sensor", self.sensor);
        f("encoder", self.encoder);
        f("neuron", self.neuron);
        f("of_kind", self.of_kind);
        f("nerve", self.nerve);
    }
};

// "SA1", "RA" or "PC".
const char* name(Kind kind);

// A patch with the encoder, neuron, afferents and spread of that kind at the fingertip. The caller adds name,
// outline and sensor. kinds.cpp cites the source of each number; docs/afferents.md compares the responses
// with the literature.
Patch preset(Kind kind);

}  // namespace scene

struct Plan;
struct PatchPlan;
class PlanItems;

// Adds the plan's items of a patch.
void add_items(const PatchPlan& patch, const Plan& plan, PlanItems& items);

}  // namespace afferent
