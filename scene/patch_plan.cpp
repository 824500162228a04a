#include "afferent/scene/patch_plan.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "afferent/runtime/parameter_error.hpp"
#include "afferent/scene/scene_faults.hpp"

namespace afferent {
namespace {

// In the order in which the decisions build on each other: names and elements, the shares of the grip force,
// then what each patch is made of.
class PatchPlanner {
  public:
    PatchPlanner(const Scene& scene, SceneFaults& faults) : scene_(scene), faults_(faults) {}

    std::vector<PatchPlan> plan() {
        lay_out();
        if (!faults_.none()) return {};
        share_the_grip();
        if (!faults_.none()) return {};
        for (std::size_t i = 0; i < patches_.size(); ++i) {
            plan_sensor(i);
            if (plan_neuron(i) && faults_.none())
                check(i, ".neuron", [&] {
                    plan_form(patches_[i], scene_.patches[i].neuron.form, traits_of(scene_.source).clocked);
                    plan_noise(i);
                });
        }
        return std::move(patches_);
    }

  private:
    PatchFaults faults_of(std::size_t index) { return {faults_, index, scene_.patches[index].name}; }
    void refuse(std::size_t index, const std::string& field, std::string text) {
        faults_of(index).refuse(field, std::move(text));
    }
    bool check(std::size_t index, const std::string& field, const std::function<void()>& rule) {
        return faults_of(index).check(field, rule);
    }

    static Duration conduction(const std::optional<scene::Nerve>& nerve) {
        return nerve ? from_milliseconds(nerve->length_mm / nerve->speed_m_per_s) : Duration::zero();
    }

    void lay_out() {
        if (scene_.patches.empty()) return faults_.add({"patch", "", "a scene must have at least one patch"});
        std::set<std::string> names;
        std::uint64_t first = 0;
        std::uint64_t first_element = 0;
        for (std::size_t i = 0; i < scene_.patches.size(); ++i) {
            const scene::Patch& given = scene_.patches[i];
            if (given.name.empty()) faults_.add({patch_path(i), "", "a patch must have a name"});
            if (!names.insert(given.name).second) refuse(i, ".name", "another patch has this name");
            const auto owner = given.elements_of ? owner_named(*given.elements_of, i) : i;
            const std::optional<ElementGrid> grid = grid_of(i);
            const std::uint32_t elements = owner != i ? patches_[owner].elements()
                                           : grid     ? grid->elements()
                                                      : given.elements;
            const AfferentSeed seed{scene_.seed, static_cast<Address>(first)};
            std::vector<Position> places = places_of(i, owner, seed);
            if (given.elements_of && given.sensor != scene::Sensor())
                refuse(i, ".sensor", "a patch with elements_of has no sensor of its own");
            patches_.push_back(
                {.name = given.name,
                 .first = static_cast<Address>(first),
                 .fields = fields_of(i, elements, owner == i ? grid : patches_[owner].grid, places, seed),
                 .places = std::move(places),
                 .reads = owner,
                 .owns_elements = owner == i,
                 .sampled = {0, elements},
                 .counted = {0, elements},
                 .first_element =
                     owner == i ? static_cast<Address>(first_element) : patches_[owner].first_element,
                 .share = {},
                 .grid = owner == i ? grid : std::nullopt,
                 .centre = scene_.patches[owner].outline.value_or(scene::Outline()).centre,
                 .sensor = scene_.patches[owner].sensor,
                 .calibration = {},
                 .encoder = {},
                 .neuron = model_of(given.neuron),
                 .variations = {},
                 .phases = {},
                 .time_classes = given.spread.time_class,
                 .target = {},
                 .noise = {},
                 .conduction = conduction(given.nerve),
                 .form = scene::Form::sparse,
                 .scan_interval = {},
                 .form_reason = {}});
            first += patches_.back().afferents();
            first_element += owner == i ? elements : 0;
            if (first > scene::most_addresses || first_element > scene::most_addresses)
                return refuse(i, ".elements",
                              "a scene has at most " + std::to_string(scene::most_addresses) + " addresses");
        }
    }

    std::size_t owner_named(const std::string& name, std::size_t index) {
        for (std::size_t i = 0; i < index; ++i)
            if (scene_.patches[i].name == name && !scene_.patches[i].elements_of) return i;
        refuse(index, ".elements_of",
               "elements_of must name an earlier patch with elements of its own, is \"" + name + "\"");
        return index;
    }

    // The elements of a patch in two dimensions.
    std::optional<ElementGrid> grid_of(std::size_t index) {
        const scene::Patch& given = scene_.patches[index];
        std::optional<ElementGrid> grid;
        if (!given.outline) {
            if (!given.elements_of && std::holds_alternative<scene::Touch>(scene_.source))
                refuse(index, ".outline", "outline must be given where stimuli touch the elements");
            return grid;
        }
        if (given.elements_of) {
            refuse(index, ".outline", "a patch with elements_of has no outline of its own");
            return grid;
        }
        check(index, ".outline", [&] {
            grid.emplace(outline_of(*given.outline), given.outline->pitch_mm, scene::most_addresses);
        });
        if (grid && given.elements != scene::Patch().elements && given.elements != grid->elements())
            refuse(index, ".elements",
                   "elements follows from the outline, " + std::to_string(grid->elements()) +
                       ", and is given as " + std::to_string(given.elements));
        return grid;
    }

    std::vector<Position> places_of(std::size_t index, std::size_t owner, AfferentSeed seed) {
        const scene::Patch& given = scene_.patches[index];
        std::vector<Position> places;
        if (!given.afferents) return places;
        if (!scene_.patches[owner].outline) {
            refuse(index, ".afferents",
                   "afferents, which every kind has, need an outline: of the patch, or of the one named by "
                   "elements_of");
            return places;
        }
        if (!given.field.empty()) refuse(index, ".field", "a patch has either fields or afferents");
        check(index, ".afferents", [&] {
            places = afferent::places_of(*given.afferents, outline_of(*scene_.patches[owner].outline), seed);
        });
        return places;
    }

    ReceptiveFields fields_of(std::size_t index, std::uint32_t elements,
                              const std::optional<ElementGrid>& grid, const std::vector<Position>& places,
                              AfferentSeed seed) {
        ReceptiveFields fields = ReceptiveFields::one_each(elements);
        const scene::Patch& given = scene_.patches[index];
        if (given.field.empty() && places.empty() && !given.spread.gain) return fields;
        FieldRows rows;
        for (const scene::Field& field : given.field) {
            for (const scene::Weight& weight : field.weight) rows.add({weight.element, weight.weight});
            rows.end_row();
        }
        if (!check(index, ".spread", [&] { afferent::check(given.spread); })) return fields;
        const bool found = check(index, ".afferents", [&] {
            if (grid && !places.empty())
                rows = gaussian_fields(*given.afferents, places, given.spread, *grid, seed);
            else if (rows.size() == 0)
                rows = fields_of_one_each(elements);
        });
        if (!found) return fields;
        spread_gain(rows, given.spread, seed);
        check(index, "", [&] { fields = ReceptiveFields(elements, std::move(rows)); });
        return fields;
    }

    void share_the_grip() {
        double given_share = 0;
        std::uint32_t without = 0;
        for (std::size_t i = 0; i < patches_.size(); ++i) {
            if (!patches_[i].owns_elements) continue;
            const std::vector<double>& shares = scene_.patches[i].share;
            for (const double share : shares) given_share += share;
            if (shares.empty())
                without += patches_[i].elements();
            else if (shares.size() != patches_[i].elements())
                refuse(i, ".share",
                       "share must be given once for each of the " + std::to_string(patches_[i].elements()) +
                           " elements, is given " + std::to_string(shares.size()) + " times");
            patches_[i].share = shares;
        }
        // A sum of rounded decimals may be a little above 1.
        if (given_share > 1 + 1e-9)
            faults_.add({patch_path(0) + ".share", "",
                         "all shares must add up to at most 1, add up to " + std::to_string(given_share)});
        for (PatchPlan& patch : patches_) {
            if (!patch.owns_elements)
                patch.share = patches_[patch.reads].share;
            else if (patch.share.empty())
                patch.share.assign(patch.elements(), std::max(0.0, 1 - given_share) / without);
        }
    }

    void plan_sensor(std::size_t index) {
        PatchPlan& patch = patches_[index];
        if (!patch.owns_elements) {
            patch.calibration = patches_[patch.reads].calibration;
            return;
        }
        check(index, ".sensor", [&] {
            afferent::check(patch.sensor, patch.elements());
            if (std::holds_alternative<scene::Touch>(scene_.source))
                require(patch.sensor.delay_ms == 0, "delay_ms", "0 beside stimuli on the skin",
                        patch.sensor.delay_ms);
            if (!patch.sensor.calibration.empty()) patch.calibration.emplace(patch.sensor.calibration);
        });
    }

    bool plan_neuron(std::size_t index) {
        PatchPlan& patch = patches_[index];
        if (!check(index, ".neuron", [&] { afferent::check(patch.neuron); })) return false;
        PatchFaults faults = faults_of(index);
        return plan_encoder(patch, scene_.patches[index], faults) && plan_variations(index);
    }

    // Held from scan to scan, it has v deviate by k / (2 - k) of its variance, with k the part of v that a
    // scan decays.
    void plan_noise(std::size_t index) {
        const scene::Neuron& neuron = scene_.patches[index].neuron;
        if (neuron.fixed_point)
            require(neuron.noise_mv == 0, "noise_mv", "0 where the neuron is fixed_point, as a chip's is",
                    neuron.noise_mv);
        const double scan_ms = Milliseconds(patches_[index].scan_interval).count();
        const double lost = -std::expm1(-scan_ms / neuron.tau_m_ms);
        patches_[index].noise = {neuron.noise_mv * std::sqrt((2 - lost) / lost), scene_.seed};
    }

    bool plan_variations(std::size_t index) {
        PatchPlan& patch = patches_[index];
        return check(index, ".spread", [&] {
            afferent::check(scene_.patches[index].spread);
            patch.variations =
                variations_of(scene_.patches[index].spread, patch.afferents(), {scene_.seed, patch.first});
            patch.phases = phases_of(scene_.patches[index].spread, {scene_.seed, patch.first});
            // A factor may take a neuron where its patch's own is not: a threshold below e_k, for one.
            for (std::uint32_t i = 0; i < patch.variations.size(); ++i) afferent::check(patch.neuron_of(i));
            patch.neurons_differ = std::ranges::any_of(patch.variations, [&](const Variation& each) {
                return each.threshold != 1 || each.delta_g != 1 || !patch.time_classes.empty();
            });
        });
    }

    const Scene& scene_;
    SceneFaults& faults_;
    std::vector<PatchPlan> patches_;
};

}  // namespace

std::vector<PatchPlan> plan_patches(const Scene& scene, SceneFaults& faults) {
    return PatchPlanner(scene, faults).plan();
}

double PatchPlan::force_n(double counts) const {
    return calibration ? calibration->force_n(counts) : Sensor(sensor).force_n(counts);
}

NeuronModel PatchPlan::neuron_of(std::uint32_t afferent) const {
    return variations.empty() ? neuron : varied(neuron, variations[afferent], time_classes);
}

std::string PatchPlan::description() const {
    std::ostringstream text;
    text << about_patch(name) << ": " << describe(neuron) << ", gain " << gain() << ", bias_mv " << bias_mv();
    return text.str();
}

}  // namespace afferent
