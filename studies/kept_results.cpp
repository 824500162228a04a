#include "afferent/studies/kept_results.hpp"

#include <algorithm>
#include <limits>
#include <string_view>

namespace afferent {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

KeptDoubt kept(Doubt doubt) {
    KeptDoubt characters{};
    const std::string_view word = name(doubt);
    std::copy(word.begin(), word.end(), characters.begin());
    return characters;
}

std::int64_t ns(TimePoint time) { return (time - scene_start).count(); }

}  // namespace

void KeptResults::expect_steps(std::size_t count, std::size_t parts_of_each) {
    steps.reserve(count);
    parts.reserve(count * parts_of_each);
}

void KeptResults::add(const ControllerStep& step) {
    const Estimate& estimate = step.estimate;
    doubts.add(estimate.doubt, step.time);
    steps.push_back({ns(step.time), step.true_force_n.value_or(unknown), estimate.force_n, estimate.sigma_n,
                     estimate.rate_hz, step.gain, step.closing_counts, step.effort.closing,
                     step.effort.opening, step.command, kept(estimate.doubt)});
    for (const PartForce& part : step.parts)
        parts.push_back({part.true_force_n.value_or(unknown), part.estimate.force_n, part.estimate.sigma_n,
                         kept(part.estimate.doubt)});
    for (const auto& [patch, contact] : step.contacts)
        contacts.push_back({ns(step.time), patch, contact.afferents, contact.force_n, contact.force_sigma_n,
                            contact.x_mm, contact.x_sigma_mm, contact.y_mm, contact.y_sigma_mm,
                            contact.area_mm2, contact.area_sigma_mm2});
    for (const EdgeTouch& touch : step.touches) {
        const EdgeFit::Edge& edge = touch.edge;
        touches.push_back({ns(touch.begin), ns(touch.told), touch.patch, touch.afferents, edge.slides,
                           edge.orientation_deg, edge.sigma_deg, edge.slides ? edge.direction_deg : unknown,
                           edge.slides ? edge.speed_mm_per_s : unknown,
                           edge.slides ? edge.speed_sigma_mm_per_s : unknown});
    }
}

}  // namespace afferent
