#include "afferent/scene/touch.hpp"

#include <algorithm>

#include "afferent/runtime/parameter_error.hpp"
#include "afferent/scene/scene_faults.hpp"

namespace afferent {
namespace {

void check_surface(const scene::Grating& grating) {
    require(grating.ridge_mm <= grating.period_mm, "ridge_mm", "at most period_mm", grating.ridge_mm);
}

void check_surface(const scene::Dots& dots) {
    require(dots.diameter_mm <= dots.spacing_mm, "diameter_mm", "at most spacing_mm", dots.diameter_mm);
}

void check_surface(const scene::Texture& texture) {
    constexpr double most_lengths = 32;  // each costs memory by its square
    require(texture.shortest_mm <= texture.longest_mm, "shortest_mm", "at most longest_mm",
            texture.shortest_mm);
    require(texture.longest_mm <= most_lengths * texture.shortest_mm, "longest_mm",
            "at most 32 times shortest_mm", texture.longest_mm);
}

void check_grasp(const scene::Grasp& grasp, const std::vector<scene::Patch>& patches) {
    check_points(grasp.point, "point");
    if (grasp.contact.empty()) throw ParameterError("contact", "given at least once", "none");
    double shares = 0;
    for (const scene::Contact& contact : grasp.contact) {
        shares += contact.share.value_or(0);
        const bool known =
            !contact.patch || std::any_of(patches.begin(), patches.end(),
                                          [&](const auto& each) { return each.name == *contact.patch; });
        if (!known)
            throw ParameterError("contact.patch", "the name of a patch", "\"" + *contact.patch + "\"");
    }
    require(shares <= 1 + 1e-9, "contact.share", "at most 1 in all", shares);
}

}  // namespace

void check_points(const std::vector<scene::ProfilePoint>& points, const std::string& field) {
    if (points.empty()) throw ParameterError(field, "given at least once", "none");
    double before_s = -1;
    for (const scene::ProfilePoint& point : points) {
        require(point.time_s > before_s, (field + ".time_s").c_str(), "increasing", point.time_s);
        before_s = point.time_s;
    }
}

void check(const scene::Touch& touch, const Scene& scene, SceneFaults& faults) {
    if (touch == scene::Touch{.skin = touch.skin})
        faults.add(
            {"source", "", "source has no stimulus: an edge, indenter, grating, dots, texture or grasp"});
    const auto check_each = [&](const auto& stimuli, const char* name, auto&& rule) {
        for (std::size_t i = 0; i < stimuli.size(); ++i)
            faults.check("source." + std::string(name) + "[" + std::to_string(i) + "]", "",
                         [&] { rule(stimuli[i]); });
    };
    check_each(touch.grating, "grating", [](const auto& grating) { check_surface(grating); });
    check_each(touch.dots, "dots", [](const auto& dots) { check_surface(dots); });
    check_each(touch.texture, "texture", [](const auto& texture) { check_surface(texture); });
    check_each(touch.grasp, "grasp", [&](const auto& grasp) { check_grasp(grasp, scene.patches); });
}

double direction_deg(const scene::Touch& touch) {
    if (!touch.edge.empty()) return touch.edge.front().direction_deg;
    if (!touch.grating.empty()) return touch.grating.front().direction_deg;
    if (!touch.dots.empty()) return touch.dots.front().direction_deg;
    return touch.texture.empty() ? 0 : touch.texture.front().direction_deg;
}

}  // namespace afferent
