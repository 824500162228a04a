#include "afferent/nodes/edge_source.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace afferent {

EdgeSource::EdgeSource(const Plan& plan)
    : SampleSource(plan),
      edge_(std::get<scene::Edge>(plan.scene.source)),
      contact_(edge_.half_width_mm, edge_.peak_kpa),
      skins_(plan.patches.size()),
      queue_(plan.patches.size()) {
    const double direction = edge_.direction_deg * std::numbers::pi / 180;
    for (const std::size_t owner : owners()) {
        const PatchPlan& patch = plan.patches[owner];
        Skin& skin = skins_[owner];
        for (std::uint32_t i = 0; i < patch.elements(); ++i) {
            const Place& place = patch.grid->place(i);
            skin.along.emplace_back(place.x_mm * std::cos(direction) + place.y_mm * std::sin(direction), i);
        }
        std::sort(skin.along.begin(), skin.along.end());
        Seconds settling(0);
        for (const PatchPlan& reader : plan.patches)
            if (reader.reads == owner) settling = std::max(settling, afferent::settling(reader.encoder));
        // A slope ends one sample after its force.
        skin.settling = 2 + static_cast<std::uint64_t>(std::ceil(settling.count() * patch.sensor.rate_hz));
        const std::uint64_t until =
            patch.sensor.noise_counts > 0 ? std::numeric_limits<std::uint64_t>::max() : skin.settling;
        skin.forces_n.assign(patch.elements(), 0);
        skin.active_until.assign(patch.elements(), until);
        skin.active.resize(patch.elements());
        std::iota(skin.active.begin(), skin.active.end(), 0U);
        schedule(owner);
    }
}

void EdgeSource::schedule(std::size_t patch) {
    queue_.schedule({sample_time(skins_[patch].sample, plan().patches[patch].sensor.rate_hz), Kind::scan,
                     static_cast<Address>(patch)});
}

// Finds the forces on all active elements at the skin's next sample.
void EdgeSource::press(Skin& skin, double pitch_mm, TimePoint time) {
    // Elements whose encoders have settled are no longer sampled. The loop below sets the forces under the
    // edge.
    std::erase_if(skin.active, [&](std::uint32_t element) {
        skin.forces_n[element] = 0;
        if (skin.active_until[element] >= skin.sample) return false;
        skin.active_until[element] = 0;
        return true;
    });
    const double middle_mm = edge_.begin_mm + edge_.speed_mm_per_s * seconds(time);
    const double reach_mm = contact_.reach_mm(pitch_mm);
    const std::size_t before = skin.active.size();
    auto touched =
        std::lower_bound(skin.along.begin(), skin.along.end(), std::pair(middle_mm - reach_mm, 0U));
    for (; touched != skin.along.end() && touched->first < middle_mm + reach_mm; ++touched) {
        const auto [along_mm, element] = *touched;
        const double from_mm = along_mm - middle_mm - pitch_mm / 2;
        skin.forces_n[element] = contact_.strip_n(from_mm, from_mm + pitch_mm);
        if (skin.active_until[element] == 0) skin.active.push_back(element);
        skin.active_until[element] = std::max(skin.active_until[element], skin.sample + skin.settling);
    }
    if (skin.active.size() > before) std::sort(skin.active.begin(), skin.active.end());
}

std::optional<Due> EdgeSource::next() {
    for (;;) {
        const Due due = queue_.next();
        Skin& skin = skins_[due.address];
        if (!pressed_) {
            press(skin, plan().patches[due.address].grid->pitch_mm(), due.time);
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

std::optional<Scan> EdgeSource::take(double) {
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

Error EdgeSource::refusal() const {
    const Due& due = queue_.next();
    return {Error::Kind::malformed, "patch \"" + plan().patches[due.address].name +
                                        "\": source.edge presses an element beyond full scale at " +
                                        std::to_string(seconds(due.time)) +
                                        " s; sensor.out_of_range is REFUSE"};
}

}  // namespace afferent
