#include "afferent/studies/trial/condition.hpp"

#include <algorithm>

#include "afferent/scene/nearest_name.hpp"

namespace afferent {
namespace {

template <class Kind>
void decode_by(scene::Decoder& decoder) {
    if (!std::holds_alternative<Kind>(decoder.kind)) decoder.kind = Kind();
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
    const auto found = std::find_if(conditions().begin(), conditions().end(),
                                    [&](const Condition& each) { return each.name == name; });
    if (found != conditions().end()) return *found;
    std::string message = "condition: there is no \"" + std::string(name) + '"';
    if (const auto nearest = nearest_name(name, condition_names()))
        message += ": did you mean \"" + *nearest + "\"?";
    throw SceneError({std::move(message)});
}

Scene Condition::applied_to(const Scene& scene) const {
    Scene applied = scene;
    if (name == "rate") decode_by<scene::SlidingWindow>(applied.decoder);
    if (name == "exponential") decode_by<scene::Exponential>(applied.decoder);
    if (name == "interval") decode_by<scene::InverseInterval>(applied.decoder);
    if (name == "inversion") decode_by<scene::Inversion>(applied.decoder);
    if (name == "filter") decode_by<scene::Filter>(applied.decoder);
    // The other conditions know no speed.
    if (feed != Feed::events || !is_filter(applied.decoder)) applied.gain.lead_ms = 0;
    return applied;
}

}  // namespace afferent
