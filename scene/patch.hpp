// A patch: elements that share a sensor, and the afferents that read them.
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

// Of afferents in the human hand.
enum class Kind { sa1, ra, pc };

struct Patch {
    std::string name = {};
    std::uint32_t elements = 3;
    // How much of the grip force each element feels. None: the elements of all such patches share equally
    // what is left of it.
    std::vector<double> share = {};
    // The elements are those of the patch with this name.
    std::optional<std::string> elements_of = {};
    // One for each afferent. None, and no `afferents`: an afferent of its own for each element.
    std::vector<Field> field = {};
    // The elements are the cells of a grid within it.
    std::optional<Outline> outline = {};
    std::optional<Afferents> afferents = {};
    Spread spread = {};
    Sensor sensor = {};
    Encoder encoder = {};
    Neuron neuron = {};
    // For people to read, with all the numbers given: what they are called.
    std::optional<Kind> of_kind = {};
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
    }
};

// "SA1", "RA" or "PC".
const char* name(Kind kind);

// A patch with the encoder, neuron, afferents and spread of that kind at the fingertip. Name, outline and
// sensor are the caller's. Each number has its source in kinds.cpp; docs/afferents.md compares their
// responses with the literature.
Patch preset(Kind kind);

}  // namespace scene

struct Plan;
struct PatchPlan;
class PlanItems;

// What the plan says of a patch.
void add_items(const PatchPlan& patch, const Plan& plan, PlanItems& items);

}  // namespace afferent
