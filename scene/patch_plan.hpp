// A patch with everything decided: its elements, and the afferents that read them.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "afferent/encoders/encoders.hpp"
#include "afferent/encoders/receptive_fields.hpp"
#include "afferent/neurons/models.hpp"
#include "afferent/neurons/tuning.hpp"
#include "afferent/runtime/event.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

struct PatchPlan {
    std::string name;

    // Its afferents have the addresses first, first + 1, ...
    Address first;
    ReceptiveFields fields;
    // Where they lie, if they have places of their own.
    std::vector<Place> places;

    // The patch whose elements they read: this one, or the one named by elements_of. Those elements are
    // first_element, first_element + 1, ... among all elements of the scene.
    std::size_t reads;
    bool owns_elements;
    Address first_element;
    std::vector<double> share;  // of the grip force, by element
    // Where these elements lie, if they are its own and the patch has two dimensions.
    std::optional<ElementGrid> grid;
    // Where the coordinates of its elements and afferents have their origin on the map of the body.
    Place centre;

    // The sensor of those elements.
    scene::Sensor sensor;
    std::optional<Calibration> calibration;

    // As given, or as tuned.
    EncoderParameters encoder;
    NeuronModel neuron;
    // How the neurons differ from it, by afferent; empty: they are alike.
    std::vector<Variation> variations;
    std::vector<scene::TimeClass> time_classes;
    // How encoder and neuron were, or would be, tuned.
    TuningTarget target;

    // Which of their two forms the neurons take, and why: a sweep over all of them per scan, or prediction.
    // AUTOMATIC: each shard goes by what happens in it, while it runs.
    scene::Form form;
    Duration scan_interval;
    std::string form_reason;

    std::uint32_t afferents() const noexcept { return fields.afferents(); }
    std::uint32_t elements() const noexcept { return fields.elements(); }
    bool sustained() const noexcept { return input(encoder) == EncoderInput::force; }
    // Whether decoders know how the drive follows from the grip force: not behind the lags of a corner
    // frequency.
    bool decodable() const noexcept { return is_decodable(encoder); }
    NeuronModel neuron_of(std::uint32_t afferent) const;
    // In more than where they begin.
    bool neurons_differ() const noexcept;
    // The share of the grip force that an afferent reads.
    double share_of(std::uint32_t afferent) const noexcept { return fields.sum(afferent, share); }
    // The largest share of the elements that it reads.
    double largest_share_of(std::uint32_t afferent) const noexcept;
    double mean_share() const noexcept;
    // The drive for one newton (per second, where transient) on an element, and the drive without force.
    double gain() const noexcept { return afferent::gain(encoder); }
    double bias_mv() const noexcept { return afferent::bias_mv(encoder); }
    // For messages: the neuron's parameters.
    std::string description() const;
};

class SceneFaults;

// The patches with everything decided; no use where there are faults.
std::vector<PatchPlan> plan_patches(const Scene& scene, SceneFaults& faults);

}  // namespace afferent
