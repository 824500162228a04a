#include "afferent/nodes/image_on_skin.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace afferent {
namespace {

struct Rectangle {
    double left = std::numeric_limits<double>::infinity();
    double right = -left;
    double bottom = left;
    double top = -left;

    void include(const Position& centre, const Outline& outline) {
        left = std::min(left, centre.x_mm - outline.width_mm / 2);
        right = std::max(right, centre.x_mm + outline.width_mm / 2);
        bottom = std::min(bottom, centre.y_mm - outline.height_mm / 2);
        top = std::max(top, centre.y_mm + outline.height_mm / 2);
    }
};

// The pixels that a cell lies on, along one axis of n: use(pixel, part of the pixel).
template <class Use>
void for_each_overlap(double from, double to, std::size_t n, Use&& use) {
    const auto last = static_cast<double>(n) - 1;
    const auto first = std::clamp(std::floor(from), 0.0, last);
    for (double pixel = first; pixel <= last && pixel < to; ++pixel)
        if (const double part = std::min(to, pixel + 1) - std::max(from, pixel); part > 0)
            use(static_cast<std::uint32_t>(pixel), part);
}

}  // namespace

ReceptiveFields image_on_skin(const Plan& plan, std::size_t rows, std::size_t columns) {
    Rectangle map;
    for (std::size_t i = 0; i < plan.patches.size(); ++i)
        if (plan.patches[i].owns_elements)
            map.include(plan.patches[i].centre, outline_of(*plan.scene.patches[i].outline));
    const double pixel_width_mm = (map.right - map.left) / static_cast<double>(columns);
    const double pixel_height_mm = (map.top - map.bottom) / static_cast<double>(rows);
    FieldRows fields;
    for (const PatchPlan& patch : plan.patches) {
        if (!patch.owns_elements) continue;
        const double half_mm = patch.grid->pitch_mm() / 2;
        for (std::uint32_t i = 0; i < patch.elements(); ++i) {
            const double x_mm = patch.centre.x_mm + patch.grid->place(i).x_mm - map.left;
            const double y_mm = map.top - patch.centre.y_mm - patch.grid->place(i).y_mm;
            for_each_overlap(
                (y_mm - half_mm) / pixel_height_mm, (y_mm + half_mm) / pixel_height_mm, rows,
                [&](std::uint32_t row, double height) {
                    for_each_overlap(
                        (x_mm - half_mm) / pixel_width_mm, (x_mm + half_mm) / pixel_width_mm, columns,
                        [&](std::uint32_t column, double width) {
                            fields.add({row * static_cast<std::uint32_t>(columns) + column, width * height});
                        });
                });
            fields.end_row();
        }
    }
    return ReceptiveFields(static_cast<std::uint32_t>(rows * columns), std::move(fields));
}

}  // namespace afferent
