#include "afferent/nodes/stimuli.hpp"

#include <algorithm>

namespace afferent {
namespace {

Position origin_of(const Plan& plan, const scene::Contact& contact) {
    if (!contact.patch) return {};
    return std::find_if(plan.patches.begin(), plan.patches.end(),
                        [&](const PatchPlan& patch) { return patch.name == *contact.patch; })
        ->centre;
}

void add_grasp(const Plan& plan, const scene::Grasp& grasp, const ElasticSkin& skin, const Aperture& aperture,
               std::vector<AnyStimulus>& stimuli) {
    double left = 1;
    double without = 0;
    for (const scene::Contact& contact : grasp.contact) {
        left -= contact.share.value_or(0);
        without += contact.share ? 0 : 1;
    }
    for (const scene::Contact& contact : grasp.contact) {
        const Position origin = origin_of(plan, contact);
        stimuli.push_back(GraspContact(origin.x_mm + contact.x_mm, origin.y_mm + contact.y_mm,
                                       contact.share ? *contact.share : std::max(0.0, left) / without,
                                       contact.radius_mm, grasp.point, skin, aperture));
    }
}

}  // namespace

std::vector<AnyStimulus> stimuli_of(const Plan& plan, const Aperture& aperture) {
    std::vector<AnyStimulus> stimuli;
    const auto* touch = touch_of(plan.scene.source);
    if (!touch) return stimuli;
    const auto surface = [&](auto relief, const auto& given) {
        stimuli.push_back(SlidingSurface(std::move(relief), given.pad, given.direction_deg,
                                         given.speed_mm_per_s, given.press, aperture));
    };
    for (const scene::Edge& edge : touch->edge) stimuli.push_back(SlidingEdge(edge, aperture));
    for (const scene::Indenter& indenter : touch->indenter) {
        stimuli.push_back(Indenter(indenter, touch->skin, aperture));
        if (touch->skin.wave)
            stimuli.push_back(IndenterWave(indenter, touch->skin, *touch->skin.wave, aperture));
    }
    for (const scene::Grating& grating : touch->grating)
        surface(Grating(grating.period_mm, grating.ridge_mm, grating.depth_mm, aperture), grating);
    for (const scene::Dots& dots : touch->dots)
        surface(Dots(dots.spacing_mm, dots.diameter_mm, dots.depth_mm, aperture), dots);
    for (const scene::Texture& texture : touch->texture) surface(Texture(texture, aperture), texture);
    for (const scene::Grasp& grasp : touch->grasp) add_grasp(plan, grasp, touch->skin, aperture, stimuli);
    return stimuli;
}

}  // namespace afferent
