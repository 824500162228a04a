#include "afferent/scene/patch_plan.hpp"

#include <algorithm>
#include <set>
#include <sstream>

#include "afferent/neurons/dense_population.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "afferent/scene/scene_faults.hpp"

namespace afferent {
namespace {

// Fewer neurons than this do not fill the vectors of a sweep often enough to pay for it.
constexpr std::uint32_t worth_sweeping = 512;

NeuronModel model_of(const scene::Neuron& neuron) {
    if (!neuron.fixed_point) return static_cast<const LifParameters&>(neuron);
    return FixedPointParameters{.lif = neuron,
                                .tick_us = neuron.fixed_point->tick_us,
                                .state_bits = neuron.fixed_point->state_bits,
                                .decay_bits = neuron.fixed_point->decay_bits,
                                .rounding = neuron.fixed_point->rounding};
}

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
            if (plan_neuron(i)) plan_form(i);
        }
        return std::move(patches_);
    }

  private:
    void refuse(std::size_t index, const std::string& field, std::string text) {
        faults_.add({patch_path(index) + field, about_patch(scene_.patches[index].name), std::move(text)});
    }

    bool check(std::size_t index, const std::string& field, const std::function<void()>& rule) {
        return faults_.check(patch_path(index) + field, about_patch(scene_.patches[index].name), rule);
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
            std::vector<Place> places = places_of(i, owner, seed);
            if (given.elements_of && given.sensor != scene::Sensor())
                refuse(i, ".sensor", "a patch with elements_of has no sensor of its own");
            patches_.push_back(
                {.name = given.name,
                 .first = static_cast<Address>(first),
                 .fields = fields_of(i, elements, owner == i ? grid : patches_[owner].grid, places, seed),
                 .places = std::move(places),
                 .reads = owner,
                 .owns_elements = owner == i,
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
                 .time_classes = given.spread.time_class,
                 .target = {},
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

    std::vector<Place> places_of(std::size_t index, std::size_t owner, AfferentSeed seed) {
        const scene::Patch& given = scene_.patches[index];
        std::vector<Place> places;
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
                              const std::optional<ElementGrid>& grid, const std::vector<Place>& places,
                              AfferentSeed seed) {
        ReceptiveFields fields = ReceptiveFields::one_each(elements);
        const scene::Patch& given = scene_.patches[index];
        if (given.field.empty() && places.empty() && !given.spread.gain) return fields;
        FieldRows rows(given.field.size());
        for (std::size_t i = 0; i < given.field.size(); ++i)
            for (const scene::Weight& weight : given.field[i].weight)
                rows[i].push_back({weight.element, weight.weight});
        if (!check(index, ".spread", [&] { afferent::check(given.spread); })) return fields;
        const bool found = check(index, ".afferents", [&] {
            if (grid && !places.empty())
                rows = gaussian_fields(*given.afferents, places, given.spread, *grid, seed);
            else if (rows.empty())
                rows = fields_of_one_each(elements);
        });
        if (!found) return fields;
        spread_gain(rows, given.spread, seed);
        check(index, "", [&] { fields = ReceptiveFields(elements, rows); });
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
            const scene::Sensor& sensor = patch.sensor;
            const Sensor made(sensor);
            if (!sensor.calibration.empty()) patch.calibration.emplace(sensor.calibration);
            for (const std::uint32_t element : sensor.dead_element)
                require(element < patch.elements(), "dead_element", "below the number of elements", element);
            for (const scene::StuckElement& stuck : sensor.stuck_element) {
                require(stuck.element < patch.elements(), "stuck_element.element",
                        "below the number of elements", stuck.element);
                require(made.within_range(stuck.force_n), "stuck_element.force_n", "0 to full_scale_n",
                        stuck.force_n);
            }
        });
    }

    bool plan_neuron(std::size_t index) {
        PatchPlan& patch = patches_[index];
        const scene::Patch& given = scene_.patches[index];
        if (!check(index, ".neuron", [&] { afferent::check(patch.neuron); })) return false;
        return plan_encoder(index, given.encoder) && plan_variations(index);
    }

    bool plan_encoder(std::size_t index, const scene::Encoder& encoder) {
        const scene::Tuning& tuning = scene_.patches[index].neuron.tuning;
        if (const auto* sustained = std::get_if<scene::Sustained>(&encoder)) {
            const GripTarget target{"force_n", tuning.force_n, "begin_force_n", tuning.begin_force_n};
            return plan_encoder(index, "sustained", target, sustained->gain_mv_per_n, sustained->bias_mv,
                                Sustained::Parameters{});
        }
        if (const auto* transient = std::get_if<scene::Transient>(&encoder)) {
            const GripTarget target{"slope_n_per_s", tuning.slope_n_per_s, "begin_slope_n_per_s",
                                    tuning.begin_slope_n_per_s};
            const EncoderParameters kind =
                transient->corner_hz
                    ? EncoderParameters(BandTransient::Parameters{0, 0, *transient->corner_hz})
                    : Transient::Parameters{};
            return plan_encoder(index, "transient", target, transient->gain_mv_s_per_n, transient->bias_mv,
                                kind);
        }
        const auto& vibration = std::get<scene::Vibration>(encoder);
        return check(index, ".encoder.vibration", [&] {
            if (!vibration.gain_mv_s2_per_n)
                throw ParameterError("gain_mv_s2_per_n", "given, as a vibration has no tuning", "absent");
            set_encoder(index, Vibration::Parameters{0, 0, vibration.corner_hz}, *vibration.gain_mv_s2_per_n,
                        vibration.bias_mv.value_or(0));
        });
    }

    void set_encoder(std::size_t index, const EncoderParameters& kind, double gain, double bias_mv) {
        patches_[index].encoder = with_gain(kind, gain, bias_mv);
        afferent::check(patches_[index].encoder);
    }

    bool plan_variations(std::size_t index) {
        PatchPlan& patch = patches_[index];
        return check(index, ".spread", [&] {
            afferent::check(scene_.patches[index].spread);
            patch.variations =
                variations_of(scene_.patches[index].spread, patch.afferents(), {scene_.seed, patch.first});
            // A factor may take a neuron where its patch's own is not: a threshold below e_k, for one.
            for (std::uint32_t i = 0; i < patch.variations.size(); ++i) afferent::check(patch.neuron_of(i));
        });
    }

    // A target as the scene has it: the grip force, or its rate of change, with the names of the fields.
    struct GripTarget {
        const char* name;
        double value;
        const char* begin_name;
        double begin;

        void check() const {
            require(begin >= 0, begin_name, ">= 0", begin);
            require(value > begin, name, (std::string("> ") + begin_name).c_str(), value);
        }
    };

    // In terms of what the mean afferent of the patch reads.
    static TuningTarget target_of(const PatchPlan& patch, const scene::Tuning& tuning,
                                  const GripTarget& target) {
        return {.rate = tuning.rate,
                .rate_hz = tuning.rate_hz,
                .input = patch.mean_share() * target.value,
                .begin_input = patch.mean_share() * target.begin,
                .other_rate_hz = tuning.other_rate_hz};
    }

    // `kind` is the encoder without its gain and bias.
    bool plan_encoder(std::size_t index, const std::string& name, const GripTarget& target,
                      std::optional<double> gain, std::optional<double> bias_mv,
                      const EncoderParameters& kind) {
        PatchPlan& patch = patches_[index];
        patch.target = target_of(patch, scene_.patches[index].neuron.tuning, target);
        if (!gain) {
            if (bias_mv) {
                refuse(index, ".encoder", "encoder: a bias without a gain; tuning solves both");
                return false;
            }
            const bool tuned = check(index, ".neuron.tuning", [&] {
                target.check();
                require(patch.mean_share() > 0, target.name, "felt by elements with a share > 0",
                        patch.mean_share());
                const Tuned solved = tune(patch.neuron, patch.target);
                gain = solved.gain;
                bias_mv = solved.bias_mv;
                patch.neuron = with_adaptation(patch.neuron, solved.delta_g);
            });
            if (!tuned) return false;
        }
        return check(index, ".encoder." + name,
                     [&] { set_encoder(index, kind, *gain, bias_mv.value_or(0)); });
    }

    void plan_form(std::size_t index) {
        PatchPlan& patch = patches_[index];
        if (!faults_.none()) return;
        patch.scan_interval = sample_time(1, patch.sensor.rate_hz) - scene_start;
        const scene::Form asked = scene_.patches[index].neuron.form;
        const auto refusal = dense_refusal(patch);
        if (asked == scene::Form::dense && refusal) {
            check(index, ".neuron",
                  [&] { throw ParameterError("form", "SPARSE here", "DENSE: " + *refusal); });
            return;
        }
        const std::string neurons = std::to_string(patch.afferents()) + " neurons";
        const bool worth_it = !refusal && patch.afferents() >= worth_sweeping;
        patch.form = asked == scene::Form::automatic && !worth_it ? scene::Form::sparse : asked;
        patch.form_reason = asked == scene::Form::sparse  ? "neuron.form is SPARSE"
                            : asked == scene::Form::dense ? "neuron.form is DENSE"
                            : refusal                     ? *refusal
                            : worth_it                    ? neurons + " on one clock"
                                                          : neurons + " are too few to sweep";
    }

    // The sweep serves populations that are sampled by a clock; prediction serves everything.
    std::optional<std::string> dense_refusal(const PatchPlan& patch) const {
        if (!is_clocked(scene_.source)) return "the samples come at times of their own";
        if (sample_time(1'000'000, patch.sensor.rate_hz) - scene_start != 1'000'000 * patch.scan_interval)
            return "the sampling interval is not a whole number of nanoseconds";
        const auto* lif = std::get_if<LifParameters>(&patch.neuron);
        if (!lif) return std::string("its neurons are ") + afferent::name(patch.neuron);
        if (!patch.time_classes.empty()) return "its neurons differ in their time constants";
        // Where neurons differ, the strongest adaptation decides.
        double largest = 1;
        for (const Variation& each : patch.variations) largest = std::max(largest, each.delta_g);
        return DensePopulation::refusal(lif->with_adaptation(largest * lif->delta_g), patch.scan_interval);
    }

    const Scene& scene_;
    SceneFaults& faults_;
    std::vector<PatchPlan> patches_;
};

}  // namespace

std::string patch_path(std::size_t index) { return "patch[" + std::to_string(index) + "]"; }
std::string about_patch(const std::string& name) { return "patch \"" + name + "\""; }

std::vector<PatchPlan> plan_patches(const Scene& scene, SceneFaults& faults) {
    return PatchPlanner(scene, faults).plan();
}

double PatchPlan::largest_share_of(std::uint32_t afferent) const noexcept {
    if (fields.is_one_each()) return share[afferent];
    double largest = 0;
    for (const auto& [element, weight] : fields.row(afferent)) largest = std::max(largest, share[element]);
    return largest;
}

NeuronModel PatchPlan::neuron_of(std::uint32_t afferent) const {
    return variations.empty() ? neuron : varied(neuron, variations[afferent], time_classes);
}

bool PatchPlan::neurons_differ() const noexcept {
    return std::any_of(variations.begin(), variations.end(), [&](const Variation& each) {
        return each.threshold != 1 || each.delta_g != 1 || !time_classes.empty();
    });
}

double PatchPlan::mean_share() const noexcept {
    double sum = 0;
    for (std::uint32_t i = 0; i < afferents(); ++i) sum += share_of(i);
    return sum / afferents();
}

std::string PatchPlan::description() const {
    std::ostringstream text;
    text << about_patch(name) << ": " << describe(neuron) << ", gain " << gain() << ", bias_mv " << bias_mv();
    return text.str();
}

}  // namespace afferent
