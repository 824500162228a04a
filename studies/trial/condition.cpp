#include "afferent/studies/trial/condition.hpp"

#include <algorithm>
#include <optional>
#include <set>

#include "afferent/scene/nearest_name.hpp"

namespace afferent {
namespace {

// Returns an error message if no condition has that name, and nothing otherwise.
std::optional<std::string> unknown_condition(std::string_view name) {
    const std::vector<std::string> names = condition_names();
    if (std::ranges::find(names, name) != names.end()) return std::nullopt;
    std::string message = "there is no \"" + std::string(name) + '"';
    if (const auto nearest = nearest_name(name, names)) message += ": did you mean \"" + *nearest + "\"?";
    return message;
}

template <class Kind>
void decode_by(scene::Decoder& decoder) {
    if (!std::holds_alternative<Kind>(decoder.kind)) decoder.kind = Kind();
}

// The condition's own gain if the scene states one, else the scene's gain; the reflexes are the scene's where
// the condition has none. Checks all stated conditions.
scene::Gain gain_of(const Scene& scene, std::string_view name) {
    const scene::Gain* own = nullptr;
    std::set<std::string> seen;
    for (std::size_t i = 0; scene.trial && i < scene.trial->conditions.size(); ++i) {
        const auto& [stated, gain] = scene.trial->conditions[i];
        const std::string path = scene.file + ": trial.condition[" + std::to_string(i) + "].";
        if (const auto fault = unknown_condition(stated)) throw SceneError({path + "name: " + *fault});
        if (!seen.insert(stated).second)
            throw SceneError({path + "name: \"" + stated + "\" stands there twice"});
        if (gain && gain->lead_ms > 0 && stated != "filter")
            throw SceneError({path + "gain.lead_ms must be 0: of the conditions, only the filter knows how "
                                     "fast the force rises"});
        if (gain && gain->pulse && condition(stated).feed == Condition::Feed::events && stated != "filter")
            throw SceneError({path + "gain.pulse must be absent: the estimate of \"" + stated +
                              "\" falls while the force holds"});
        if (stated == name && gain) own = &*gain;
    }
    if (!own) return scene.gain;
    scene::Gain gain = *own;
    if (!gain.brake) gain.brake = scene.gain.brake;
    if (!gain.pulse) gain.pulse = scene.gain.pulse;
    return gain;
}

}  // namespace

const std::vector<Condition>& conditions() {
    using Feed = Condition::Feed;
    static const std::vector<Condition> all{
        {"none", Feed::nothing},    {"force", Feed::samples},
        {"rate", Feed::events},     {"exponential", Feed::events},
        {"interval", Feed::events}, {"inversion", Feed::events},
        {"filter", Feed::events},   {"send_on_delta", Feed::send_on_delta},
    };
    return all;
}

std::vector<std::string> condition_names() {
    std::vector<std::string> names;
    for (const Condition& each : conditions()) names.push_back(each.name);
    return names;
}

const Condition& condition(std::string_view name) {
    if (const auto fault = unknown_condition(name)) throw SceneError({"condition: " + *fault});
    return *std::ranges::find(conditions(), name, &Condition::name);
}

Scene Condition::applied_to(const Scene& scene) const {
    Scene applied = scene;
    applied.gain = gain_of(scene, name);
    if (name == "rate") decode_by<scene::SlidingWindow>(applied.decoder);
    if (name == "exponential") decode_by<scene::Exponential>(applied.decoder);
    if (name == "interval") decode_by<scene::InverseInterval>(applied.decoder);
    if (name == "inversion") decode_by<scene::Inversion>(applied.decoder);
    if (name == "filter") decode_by<scene::Filter>(applied.decoder);
    // The other conditions know no speed.
    if (feed != Feed::events || !is_filter(applied.decoder)) applied.gain.lead_ms = 0;
    if (feed == Feed::events && !is_filter(applied.decoder)) applied.gain.pulse.reset();
    // These conditions estimate the force from samples; the decoder only has to be one that a pulse may have.
    if (feed != Feed::events && applied.gain.pulse) decode_by<scene::Filter>(applied.decoder);
    return applied;
}

}  // namespace afferent
