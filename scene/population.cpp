#include "afferent/scene/population.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace afferent {
namespace {

std::string kind_of(const Plan& plan, std::size_t patch) {
    const auto kind = plan.scene.patches[patch].of_kind;
    return kind ? scene::name(*kind) : name(plan.patches[patch].encoder);
}

Population::Afferent afferent_of(const Plan& plan, const PatchPlan& patch, std::uint32_t index) {
    Population::Afferent afferent;
    std::uint32_t element = index;
    if (!patch.fields.is_one_each()) {
        const auto row = patch.fields.row(index);
        element = std::ranges::max_element(row, {}, &FieldWeight::weight)->element;
        afferent.elements = static_cast<std::uint32_t>(row.size());
    }
    afferent.element = patch.first_element + element;
    // Without a place of its own it lies where it reads most.
    const std::optional<ElementGrid>& grid = plan.patches[patch.reads].grid;
    if (!patch.places.empty())
        afferent.place = on_map(patch, patch.places[index]);
    else if (grid)
        afferent.place = on_map(patch, grid->place(element));
    return afferent;
}

std::vector<Position> corners_of(const Outline& outline) {
    const double x = outline.width_mm / 2;
    const double y = outline.height_mm / 2;
    if (outline.shape == Outline::Shape::rectangle) return {{-x, -y}, {x, -y}, {x, y}, {-x, y}};
    constexpr int corners = 90;  // off the ellipse by less than a thousandth of its size
    std::vector<Position> places;
    for (int i = 0; i < corners; ++i) {
        const double angle = 2 * std::numbers::pi * i / corners;
        places.push_back({x * std::cos(angle), y * std::sin(angle)});
    }
    return places;
}

}  // namespace

Position on_map(const PatchPlan& patch, const Position& place) {
    return {patch.centre.x_mm + place.x_mm, patch.centre.y_mm + place.y_mm};
}

Population population_of(const Plan& plan) {
    Population population;
    population.afferents.reserve(plan.addresses);
    for (std::size_t i = 0; i < plan.patches.size(); ++i) {
        const PatchPlan& patch = plan.patches[i];
        population.patches.push_back({patch.name, patch.afferents(), kind_of(plan, i)});
        for (std::uint32_t index = 0; index < patch.afferents(); ++index)
            population.afferents.push_back(afferent_of(plan, patch, index));
    }
    return population;
}

Skin skin_of(const Plan& plan) {
    Skin skin;
    skin.elements.reserve(plan.elements);
    for (std::size_t i = 0; i < plan.patches.size(); ++i) {
        const PatchPlan& patch = plan.patches[i];
        if (!patch.owns_elements) continue;
        if (!patch.grid) {
            skin.elements.resize(skin.elements.size() + patch.elements());
            continue;
        }
        for (std::uint32_t element = 0; element < patch.elements(); ++element)
            skin.elements.push_back({on_map(patch, patch.grid->place(element)), patch.grid->pitch_mm()});
        std::vector<Position>& outline = skin.outlines.emplace_back();
        for (const Position& corner : corners_of(outline_of(*plan.scene.patches[i].outline)))
            outline.push_back(on_map(patch, corner));
    }
    return skin;
}

double stimulus_direction_deg(const Scene& scene) {
    const auto* touch = std::get_if<scene::Touch>(&scene.source);
    return touch ? direction_deg(*touch) : 0;
}

}  // namespace afferent
