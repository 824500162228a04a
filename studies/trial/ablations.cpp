#include "afferent/studies/trial/ablations.hpp"

#include <algorithm>
#include <array>
#include <variant>

namespace afferent {
namespace {

Scene without_adaptation(const Scene& scene, std::string_view) {
    Scene changed = scene;
    for (scene::Patch& patch : changed.patches) patch.neuron.delta_g = 0;
    return changed;
}

// What the elements of the patches measure together.
double full_scale_n(const Scene& scene) {
    double sum_n = 0;
    for (const scene::Patch& patch : scene.patches)
        if (!patch.elements_of) sum_n += patch.elements * patch.sensor.full_scale_n;
    return sum_n;
}

Scene with_one_neuron(const Scene& scene, std::string_view) {
    Scene changed = scene;
    scene::Patch grip = scene.patches.front();
    grip.name = "grip";
    grip.elements = 1;
    grip.share = {};
    // Three fingertips share the force, and none of them gets more than all of it.
    grip.sensor.full_scale_n = std::min(full_scale_n(scene), scene.trial->motor.force_limit_n);
    changed.patches = {grip};
    changed.decoder.patch = {};
    return changed;
}

Scene with_transient_neurons(const Scene& scene, std::string_view condition) {
    Scene changed = scene;
    for (const scene::Patch& patch : scene.patches) {
        if (!std::holds_alternative<scene::Sustained>(patch.encoder) || patch.elements_of) continue;
        scene::Patch transient;
        transient.name = patch.name + ", transient";
        transient.elements_of = patch.name;
        transient.encoder = scene::Transient();
        transient.neuron = patch.neuron;
        changed.patches.push_back(transient);
    }
    // The others read rates, which a change of force has for a moment only.
    changed.decoder.patch = {};
    if (condition == "filter")
        for (const scene::Patch& patch : changed.patches) changed.decoder.patch.push_back(patch.name);
    return changed;
}

}  // namespace

std::span<const Ablation> ablations() {
    static const std::array<Ablation, 3> all{
        Ablation{"no_adaptation",
                 "neurons that do not adapt",
                 {"rate", "exponential", "interval", "inversion", "filter"},
                 without_adaptation},
        Ablation{"one_neuron",
                 "one neuron on the grip force",
                 {"rate", "exponential", "interval", "inversion", "filter"},
                 with_one_neuron},
        Ablation{"transient_added", "transient neurons added", {"filter"}, with_transient_neurons},
    };
    return all;
}

const Ablation* find_ablation(std::string_view name) {
    const auto all = ablations();
    const auto found = std::ranges::find(all, name, &Ablation::name);
    return found == all.end() ? nullptr : &*found;
}

}  // namespace afferent
