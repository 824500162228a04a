#include "afferent/apps/population_view.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "afferent/scene/population.hpp"

namespace afferent {
namespace {

// A picture cannot show more: of more spikes it shows how densely they lie.
constexpr std::size_t most_spikes_drawn = 300'000;
// The skin is seen in the busiest of spans of this length, or of this part of a longer scene.
constexpr Duration shortest_span = 50ms;
constexpr std::int64_t most_spans = 200;

Duration span_of(const Scene& scene) {
    const Duration whole = scene.end() - scene_start;
    return std::min(whole, std::max<Duration>(shortest_span, whole / most_spans));
}

std::string direction_of(const Scene& scene) {
    const double degrees = stimulus_direction_deg(scene);
    if (degrees == 0) return "along x";
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "along %g° from x", degrees);
    return text.data();
}

// Where an edge is the only stimulus: when it passes a place is then easily told.
std::optional<PopulationPicture::Passing> passing_of(const Scene& scene) {
    const auto* touch = touch_of(scene.source);
    if (!touch || touch->edge.size() != 1 || !touch->indenter.empty() || !touch->grating.empty() ||
        !touch->dots.empty() || !touch->texture.empty() || !touch->grasp.empty())
        return std::nullopt;
    const scene::Edge& edge = touch->edge.front();
    if (edge.speed_mm_per_s == 0) return std::nullopt;
    return PopulationPicture::Passing{
        "the edge's middle", edge.begin_mm - edge.speed_mm_per_s * edge.press.begin_s, edge.speed_mm_per_s};
}

}  // namespace

PopulationView::PopulationView(const Plan& plan)
    : plan_(plan),
      population_(population_of(plan)),
      skin_(skin_of(plan)),
      rows_(population_, stimulus_direction_deg(plan.scene)),
      span_(span_of(plan.scene)),
      pressure_(plan.elements, scene_start + span_ / 2, span_, most_spans + 1),
      current_{.spikes = std::vector<std::uint32_t>(plan.addresses)},
      busiest_(current_),
      spikes_of_kind_(rows_.kinds().size()) {}

void PopulationView::events(std::span<const Event> events) {
    all_spikes_ += events.size();
    for (const Event& event : events) {
        const std::int64_t number = (event.time - scene_start) / span_;
        if (number != current_.number) {
            end_span();
            current_.number = number;
        }
        ++current_.events;
        ++current_.spikes[event.address];
        ++spikes_of_kind_[rows_.kind(event.address)];
        by_row_.push_back({event.time, rows_.row(event.address)});
    }
    if (!density_ && by_row_.size() > most_spikes_drawn)
        density_.emplace(0, seconds(plan_.end()), rows_.afferents());
    if (!density_) return;
    density_->add(by_row_);
    by_row_.clear();
}

void PopulationView::end_span() {
    if (current_.events > busiest_.events) std::swap(current_, busiest_);
    current_.events = 0;
    std::ranges::fill(current_.spikes, 0);
}

Drawing PopulationView::draw(TimePoint end, const std::filesystem::path& stem) {
    end_span();
    pressure_.finish(end);
    const TimePoint from = scene_start + busiest_.number * span_;
    const auto& frames = pressure_.frames();
    const auto frame = static_cast<std::size_t>(busiest_.number);
    PopulationPicture picture{.title = plan_.scene.name,
                              .end_s = std::max(seconds(end), seconds(scene_start + span_)),
                              .population = population_,
                              .skin = skin_,
                              .rows = rows_,
                              .direction = direction_of(plan_.scene),
                              .passing = passing_of(plan_.scene),
                              .from_s = seconds(from),
                              .to_s = seconds(from + span_),
                              .spikes = busiest_.spikes,
                              .pressed = {},
                              .all_spikes = all_spikes_,
                              .spikes_of_kind = spikes_of_kind_,
                              .events = std::move(by_row_),
                              .density = std::move(density_)};
    if (frame < frames.size()) picture.pressed = frames[frame];
    return afferent::draw(picture, stem);
}

}  // namespace afferent
