// A patch with everything decided: its elements, and the afferents that read them.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "afferent/encoders/element_grid.hpp"
#include "afferent/encoders/encoders.hpp"
#include "afferent/encoders/receptive_fields.hpp"
#include "afferent/neurons/models.hpp"
#include "afferent/neurons/neuron.hpp"
#include "afferent/neurons/tuning.hpp"
#include "afferent/runtime/event.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// How the neuron of an afferent differs from that of its patch.
struct Variation {
    double threshold = 1;  // times the distance from v_r to v_th
    double delta_g = 1;    // times the neuron's own
    std::uint32_t time_class = 0;
};

// What the afferents of a patch add to their drives at each scan.
struct DriveNoise {
    double sd_mv = 0;
    std::uint64_t seed = 0;
    // It is cut at so many standard deviations.
    static constexpr double most_deviations = 4;
    double largest_mv() const noexcept { return most_deviations * sd_mv; }
};

struct PatchPlan {
    std::string name;

    // Its afferents have the addresses first, first + 1, ...
    Address first;
    ReceptiveFields fields;
    // Where they lie, if they have places of their own.
    std::vector<Position> places;

    // The patch whose elements they read: this one, or the one named by elements_of. Those elements are
    // first_element, first_element + 1, ... among all elements of the scene.
    std::size_t reads;
    bool owns_elements;
    // The elements that this process samples, and those whose samples it counts: all of its own, unless the
    // scene runs on several ranks.
    ElementRange sampled;
    ElementRange counted;
    Address first_element;
    std::vector<double> share;  // of the grip force, by element
    // Where these elements lie, if they are its own and the patch has two dimensions.
    std::optional<ElementGrid> grid;
    // Where the coordinates of its elements and afferents have their origin on the map of the body.
    Position centre;

    // The sensor of those elements.
    scene::Sensor sensor;
    std::optional<Calibration> calibration;

    // As given, or as tuned.
    EncoderParameters encoder;
    NeuronModel neuron;
    // How the neurons differ from it, by afferent; empty: they are alike.
    std::vector<Variation> variations;
    bool neurons_differ = false;
    Phases phases;  // by afferent
    std::vector<scene::TimeClass> time_classes;
    // How encoder and neuron were, or would be, tuned.
    TuningTarget target;

    DriveNoise noise;
    // From a spike until its event leaves.
    Duration conduction;

    // Which of their two forms the neurons take, and why: a sweep over all of them per scan, or prediction.
    // AUTOMATIC: each shard goes by what happens in it, while it runs.
    scene::Form form;
    Duration scan_interval;
    std::string form_reason;

    std::uint32_t afferents() const noexcept { return fields.afferents(); }
    std::uint32_t elements() const noexcept { return fields.elements(); }
    bool sustained() const noexcept { return input(encoder) == EncoderInput::force; }
    // Whether the drive follows from force alone: sustained, without a dynamic term.
    bool proportional() const noexcept { return sustained() && decodable(); }
    // Whether decoders know how the drive follows from the grip force: not behind the lags of a corner
    // frequency, nor from half of a wave.
    bool decodable() const noexcept { return is_decodable(encoder); }
    NeuronModel neuron_of(std::uint32_t afferent) const;
    // The age of the force that an event tells of when it leaves.
    Duration delay() const { return from_milliseconds(sensor.delay_ms) + conduction; }
    // The force on an element that works, of so many counts of its converter.
    double force_n(double counts) const;
    // The share of the grip force that an afferent reads.
    double share_of(std::uint32_t afferent) const noexcept { return fields.sum(afferent, share); }
    // The largest share of the elements that it reads.
    double largest_share_of(std::uint32_t afferent) const noexcept {
        if (fields.is_one_each()) return share[afferent];
        double largest = 0;
        for (const auto& [element, weight] : fields.row(afferent))
            largest = std::max(largest, share[element]);
        return largest;
    }
    double mean_share() const noexcept {
        double sum = 0;
        for (std::uint32_t i = 0; i < afferents(); ++i) sum += share_of(i);
        return sum / afferents();
    }
    // The drive for one newton (per second, where transient) on an element, and the drive without force.
    double gain() const noexcept { return afferent::gain(encoder); }
    double bias_mv() const noexcept { return afferent::bias_mv(encoder); }
    // For messages: the neuron's parameters.
    std::string description() const;
};

class PatchFaults;
class SceneFaults;

// The patches with everything decided; no use where there are faults.
std::vector<PatchPlan> plan_patches(const Scene& scene, SceneFaults& faults);

// What the topics of a patch decide, in the order in which it is decided. Spreads are checked.

// The numbers drawn for an afferent are a function of the scene's seed and the afferent's address, so they
// are the same for any number of threads and any order of drawing.
struct AfferentSeed {
    std::uint64_t seed;
    Address first;  // of the patch
};

// Throws ParameterError, as jittered_lattice does, or for a place outside the outline.
std::vector<Position> places_of(const scene::Afferents& afferents, const Outline& outline, AfferentSeed seed);

// The standard deviation of the narrowest Gaussian field that elements of a pitch allow for.
double narrowest_field_sd_mm(double pitch_mm);
// Gaussian fields around those places, whose sizes may differ, on elements that have the aperture of a
// stimulus; one that is narrower than those elements allow for is as wide as that. Throws ParameterError: not
// too many weights.
FieldRows gaussian_fields(const scene::Afferents& afferents, const std::vector<Position>& places,
                          const scene::Spread& spread, const ElementGrid& grid, AfferentSeed seed);
// A row for each element.
FieldRows fields_of_one_each(std::uint32_t elements);
// An afferent whose gain is k times the encoder's reads k times as much.
void spread_gain(FieldRows& rows, const scene::Spread& spread, AfferentSeed seed);

// Empty if all neurons have the same parameters.
std::vector<Variation> variations_of(const scene::Spread& spread, std::uint32_t afferents, AfferentSeed seed);
// None if all neurons begin at rest.
Phases phases_of(const scene::Spread& spread, AfferentSeed seed);

// The neuron with that variation, where classes of time constants are the spread's.
NeuronModel varied(const NeuronModel& neuron, const Variation& variation,
                   const std::vector<scene::TimeClass>& classes);

NeuronModel model_of(const scene::Neuron& neuron);

// Decides the encoder, and by its tuning the neuron's adaptation, of a patch whose neuron and shares are
// decided. False: there are faults.
bool plan_encoder(PatchPlan& plan, const scene::Patch& patch, PatchFaults& faults);

// "drive in proportion to force"
std::string describe(const EncoderParameters& encoder);

// Decides the form of a patch whose neuron and sensor are decided; `clocked`: its scans come at the sensor's
// own rate. Throws ParameterError where the scene asks for a sweep that cannot serve it.
void plan_form(PatchPlan& plan, scene::Form asked, bool clocked);

}  // namespace afferent
