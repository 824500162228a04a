// Where the afferents of a patch lie, what they read, and how they differ from each other.
#pragma once

#include <cstdint>
#include <vector>

#include "afferent/encoders/element_grid.hpp"
#include "afferent/encoders/outline.hpp"
#include "afferent/encoders/receptive_fields.hpp"
#include "afferent/neurons/models.hpp"
#include "afferent/runtime/event.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// The numbers drawn for an afferent are a function of the scene's seed and the afferent's address, so they
// are the same for any number of threads and any order of drawing.
struct AfferentSeed {
    std::uint64_t seed;
    Address first;  // of the patch
};

// Throws ParameterError: factors > 0 in all their values. The functions below take it as checked.
void check(const scene::Spread& spread);

Outline outline_of(const scene::Outline& outline);

// Throws ParameterError, as jittered_lattice does, or for a place outside the outline.
std::vector<Place> places_of(const scene::Afferents& afferents, const Outline& outline, AfferentSeed seed);

using FieldRows = std::vector<std::vector<ReceptiveFields::Weight>>;

// Gaussian fields around those places, whose sizes may differ. Throws ParameterError: not too many weights.
FieldRows gaussian_fields(const scene::Afferents& afferents, const std::vector<Place>& places,
                          const scene::Spread& spread, const ElementGrid& grid, AfferentSeed seed);
// A row for each element.
FieldRows fields_of_one_each(std::uint32_t elements);
// An afferent whose gain is k times the encoder's reads k times as much.
void spread_gain(FieldRows& rows, const scene::Spread& spread, AfferentSeed seed);

// How the neuron of an afferent differs from that of its patch.
struct Variation {
    double threshold = 1;  // times the distance from v_r to v_th
    double delta_g = 1;    // times the neuron's own
    double phase = 0;      // where v begins, as a part of the way from v_r to v_th
    std::uint32_t time_class = 0;
};

// Empty if all neurons have the same parameters and phase.
std::vector<Variation> variations_of(const scene::Spread& spread, std::uint32_t afferents, AfferentSeed seed);

// The neuron with that variation, where classes of time constants are the spread's.
NeuronModel varied(const NeuronModel& neuron, const Variation& variation,
                   const std::vector<scene::TimeClass>& classes);

}  // namespace afferent
