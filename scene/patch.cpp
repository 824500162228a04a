#include "afferent/scene/patch.hpp"

#include "afferent/scene/plan.hpp"
#include "afferent/scene/plan_bounds.hpp"
#include "afferent/scene/scene_faults.hpp"

namespace afferent {
namespace {

// What is known of the fields of afferents at places of their own.
std::string fields_of(const scene::Afferents& afferents, double pitch_mm) {
    const double narrowest_mm = narrowest_field_sd_mm(pitch_mm);
    if (afferents.field_sd_mm >= narrowest_mm) return "";
    return ", whose fields are " + decimal(narrowest_mm) + " mm in place of " +
           decimal(afferents.field_sd_mm) + ": a pitch of " + decimal(pitch_mm) + " mm allows for no less";
}

std::string two_dimensions(const PatchPlan& patch, const Plan& plan) {
    std::string reason;
    if (patch.grid) reason = "elements in a grid of " + decimal(patch.grid->pitch_mm()) + " mm";
    if (!patch.places.empty())
        reason += (reason.empty() ? "" : ", ") + std::to_string(patch.places.size()) +
                  " afferents at places of their own";
    const auto& afferents =
        plan.scene.patches[static_cast<std::size_t>(&patch - plan.patches.data())].afferents;
    if (!patch.places.empty() && afferents)
        reason += fields_of(*afferents, plan.patches[patch.reads].grid->pitch_mm());
    return reason.empty() ? "outline is not given" : reason;
}

}  // namespace

void add_items(const PatchPlan& patch, const Plan& plan, PlanItems& items) {
    const auto add = [&](const std::string& what, bool built, std::string reason) {
        items.add(about_patch(patch.name) + ": " + what, built, std::move(reason));
    };
    const auto index = static_cast<std::size_t>(&patch - plan.patches.data());
    add("sensors", patch.owns_elements,
        patch.owns_elements ? std::to_string(patch.elements()) + " elements"
                            : "it reads those of \"" + plan.patches[patch.reads].name + "\"");
    add("receptive fields", !patch.fields.is_one_each(),
        patch.fields.is_one_each() ? "each afferent reads an element of its own"
                                   : std::to_string(patch.afferents()) + " afferents with rows of weights");
    add("two dimensions", patch.grid.has_value() || !patch.places.empty(), two_dimensions(patch, plan));
    add(name(patch.encoder) + std::string(" encoder"), true, describe(patch.encoder));
    if (const auto* sustained = std::get_if<scene::Sustained>(&plan.scene.patches[index].encoder)) {
        const std::string field = "encoder.sustained.";
        add("dynamic term", sustained->dynamic.has_value(),
            field +
                (sustained->dynamic ? "dynamic: a rise of the force drives, too" : "dynamic is not given"));
        add("slow adaptation", sustained->slow_adaptation.has_value(),
            field + (sustained->slow_adaptation ? "slow_adaptation: a held force drives less and less"
                                                : "slow_adaptation is not given"));
    }
    if (!can_fire(plan, patch))
        add("spikes", false, "no sample of its sensors drives a neuron beyond its threshold");
    const std::string differ = differences(plan.scene.patches[index].spread, !patch.places.empty());
    add("spread", !differ.empty(),
        differ.empty() ? "spread is not given: afferents are alike" : "afferents differ in " + differ);
    add(describe(patch.form), true, patch.form_reason);
    add("adaptation", adaptation(patch.neuron) > 0, "delta_g is " + decimal(adaptation(patch.neuron)));
    add("refractory period", refractory(patch.neuron) > Milliseconds(0),
        "refractory_ms is " + decimal(refractory(patch.neuron).count()));
    const double noise_mv = plan.scene.patches[index].neuron.noise_mv;
    add("irregular intervals", noise_mv > 0,
        "neuron.noise_mv is " + decimal(noise_mv) + (noise_mv > 0 ? ", of which no decoder knows" : ""));
    add("nerve", patch.conduction > 0ns,
        patch.conduction > 0ns
            ? "each event leaves " + decimal(Milliseconds(patch.conduction).count()) + " ms after its spike"
            : "nerve is not given");
    if (patch.owns_elements)
        add("noise", patch.sensor.noise_counts > 0,
            "sensor.noise_counts is " + decimal(patch.sensor.noise_counts));
}

}  // namespace afferent
