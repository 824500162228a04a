#include "afferent/nodes/stimulus_source.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

namespace afferent {
namespace {

// Encoders take the force to change along the straight line from one sample to the next, so that an element
// has to be sampled right before it is pressed. Not by an edge, which is slow, and whose pressure begins at
// 0: skin that edges slide over is sampled at the beginning instead.
template <class S>
inline constexpr bool is_sampled_ahead = true;
template <>
inline constexpr bool is_sampled_ahead<SlidingEdge> = false;

bool has_edge(const std::vector<AnyStimulus>& stimuli) {
    return std::any_of(stimuli.begin(), stimuli.end(),
                       [](const auto& each) { return std::holds_alternative<SlidingEdge>(each); });
}

bool reads_0_at_rest(const PatchPlan& patch) {
    if (!patch.sensor.stuck_element.empty()) return false;
    const Sensor sensor(patch.sensor);
    Sensor::State state;
    const double counts = sensor.counts(state, 0, 0);
    return (patch.calibration ? patch.calibration->force_n(counts) : sensor.force_n(counts)) == 0;
}

// use(element, place) for all elements that are sampled and that a pressure touches.
template <Pressure P, class Use>
void for_each_touched(const P& pressure, const PatchPlan& patch, Use&& use) {
    const ElementGrid& grid = *patch.grid;
    const double pitch_mm = grid.pitch_mm();
    const Stretch rows = pressure.rows();
    const double first = std::floor((rows.from_mm - patch.centre.y_mm - grid.row_y_mm(0)) / pitch_mm);
    const double last = std::ceil((rows.to_mm - patch.centre.y_mm - grid.row_y_mm(0)) / pitch_mm);
    if (!(last >= 0)) return;
    const auto end = static_cast<std::uint32_t>(std::min<double>(last + 1, grid.rows()));
    for (auto row = static_cast<std::uint32_t>(std::clamp<double>(first, 0, grid.rows())); row < end; ++row) {
        const double y_mm = patch.centre.y_mm + grid.row_y_mm(row);
        if (!rows.contains(y_mm)) continue;
        const Stretch columns = pressure.columns(y_mm);
        const auto places = grid.row(row);
        auto place = std::lower_bound(
            places.begin(), places.end(), columns.from_mm,
            [&](const Position& each, double from_mm) { return patch.centre.x_mm + each.x_mm < from_mm; });
        for (; place != places.end() && patch.centre.x_mm + place->x_mm < columns.to_mm; ++place) {
            const std::uint32_t element =
                grid.first_of_row(row) + static_cast<std::uint32_t>(place - places.begin());
            if (patch.sampled.contains(element))
                use(element, Position{patch.centre.x_mm + place->x_mm, y_mm});
        }
    }
}

}  // namespace

StimulusSource::StimulusSource(const Plan& plan)
    : SampleSource(plan), skins_(plan.patches.size()), queue_(plan.patches.size()) {
    for (const std::size_t owner : owners()) {
        begin(owner);
        schedule(owner);
    }
}

void StimulusSource::begin(std::size_t owner) {
    const PatchPlan& patch = plan().patches[owner];
    Skin& skin = skins_[owner];
    const double pitch_mm = patch.grid->pitch_mm();
    if (!stimuli_.contains(pitch_mm)) stimuli_[pitch_mm] = stimuli_of(plan(), Aperture(pitch_mm));
    skin.stimuli = &stimuli_[pitch_mm];
    Seconds settling(0);
    for (const PatchPlan& reader : plan().patches)
        if (reader.reads == owner) settling = std::max(settling, afferent::settling(reader.encoder));
    // A slope ends one sample after its force.
    skin.settling = 2 + static_cast<std::uint64_t>(std::ceil(settling.count() * patch.sensor.rate_hz));
    skin.forces_n.assign(patch.elements(), 0);
    skin.active_until.assign(patch.elements(), 0);
    std::uint64_t until = 0;
    if (patch.sensor.noise_counts > 0)
        until = std::numeric_limits<std::uint64_t>::max();
    else if (has_edge(*skin.stimuli))
        until = skin.settling;
    else if (!reads_0_at_rest(patch))
        until = 1;
    if (until == 0) return;
    const ElementRange& sampled = patch.sampled;
    std::fill_n(skin.active_until.begin() + sampled.begin, sampled.size(), until);
    skin.active.resize(sampled.size());
    std::iota(skin.active.begin(), skin.active.end(), sampled.begin);
}

TimePoint StimulusSource::time_of(std::size_t patch, std::uint64_t sample) const noexcept {
    return sample_time(sample, plan().patches[patch].sensor.rate_hz);
}

void StimulusSource::schedule(std::size_t patch) {
    queue_.schedule({time_of(patch, skins_[patch].sample), Kind::scan, static_cast<Address>(patch)});
}

void StimulusSource::activate(Skin& skin, std::uint32_t element, std::uint64_t until) {
    if (skin.active_until[element] == 0) fresh_.push_back(element);
    skin.active_until[element] = std::max(skin.active_until[element], until);
}

// Finds the forces on all active elements at the skin's next sample.
void StimulusSource::press(std::size_t patch, TimePoint time) {
    Skin& skin = skins_[patch];
    const PatchPlan& planned = plan().patches[patch];
    std::erase_if(skin.active, [&](std::uint32_t element) {
        skin.forces_n[element] = 0;
        if (skin.active_until[element] >= skin.sample) return false;
        skin.active_until[element] = 0;
        return true;
    });
    fresh_.clear();
    for (const AnyStimulus& any : *skin.stimuli)
        std::visit(
            [&]<class S>(const S& stimulus) {
                const auto pressure = stimulus.at(time);
                for_each_touched(pressure, planned, [&](std::uint32_t element, const Position& place) {
                    skin.forces_n[element] += pressure.force_n(place);
                    activate(skin, element, skin.sample + skin.settling);
                });
                if constexpr (is_sampled_ahead<S>)
                    for_each_touched(stimulus.at(time_of(patch, skin.sample + 1)), planned,
                                     [&](std::uint32_t element, const Position&) {
                                         activate(skin, element, skin.sample + 1);
                                     });
            },
            any);
    if (fresh_.empty()) return;
    std::sort(fresh_.begin(), fresh_.end());
    merged_.clear();
    std::merge(skin.active.begin(), skin.active.end(), fresh_.begin(), fresh_.end(),
               std::back_inserter(merged_));
    skin.active.swap(merged_);
}

std::optional<Due> StimulusSource::next() {
    for (;;) {
        const Due due = queue_.next();
        Skin& skin = skins_[due.address];
        if (!pressed_) {
            press(due.address, due.time);
            pressed_ = true;
            taken_ = 0;
        }
        if (taken_ < skin.active.size() || due.time > plan().end()) return due;
        // Nothing is touched.
        queue_.pop();
        ++skin.sample;
        schedule(due.address);
        pressed_ = false;
    }
}

std::optional<Scan> StimulusSource::take(double) {
    const Due due = *next();
    const PatchPlan& patch = plan().patches[due.address];
    Skin& skin = skins_[due.address];
    const std::size_t begin = taken_;
    const std::uint32_t first = begin < skin.active.size() ? skin.active[begin] : 0;
    while (taken_ < skin.active.size() && skin.active[taken_] == first + (taken_ - begin)) ++taken_;
    PatchSensors& sensors = this->sensors(due.address);
    const std::uint64_t clipped = sensors.clipped();
    const auto forces_n =
        sensors.feel_elements(first, std::span(skin.forces_n).subspan(first, taken_ - begin), skin.sample);
    if (patch.sensor.out_of_range == scene::OutOfRange::refuse && sensors.clipped() != clipped)
        return std::nullopt;
    if (taken_ == skin.active.size()) {
        queue_.pop();
        ++skin.sample;
        schedule(due.address);
        pressed_ = false;
    }
    return Scan{due.time, patch.first_element + first, forces_n};
}

Error StimulusSource::refusal() const {
    const Due& due = queue_.next();
    return {Error::Kind::malformed, "patch \"" + plan().patches[due.address].name +
                                        "\": the stimuli press an element beyond full scale at " +
                                        std::to_string(seconds(due.time)) +
                                        " s; sensor.out_of_range is REFUSE"};
}

}  // namespace afferent
