#include "afferent/studies/tuning.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <span>
#include <utility>

#include "afferent/engine/make_shard.hpp"
#include "afferent/hand/disc_contact.hpp"
#include "afferent/runtime/spike_storm.hpp"
#include "afferent/scene/population.hpp"

namespace afferent {
namespace {

constexpr double deepest_mm = 3;
constexpr double least_mm = 1e-6;
constexpr double threshold_ratio = 1.01;  // between an amplitude that is too small and one that is not
constexpr double press_rise_s = 0.05;
constexpr double frequencies_hz[] = {1,  2,   5,   10,  15,  20,  30,  45,  60,
                                     80, 100, 150, 200, 250, 300, 350, 400, 500};
// A sine of fewer samples a cycle is another stimulus.
constexpr double least_samples_a_cycle = 4;
constexpr double depths_mm[] = {0.05, 0.1, 0.2, 0.3, 0.5, 0.75, 1, 1.25, 1.5, 2};
constexpr double field_thresholds = 4.5;
constexpr int field_steps = 20;  // from the middle to its end

Error not_allowed(std::string text) { return {Error::Kind::not_allowed, std::move(text)}; }

ElasticSkin skin_of(const Scene& scene) {
    const auto* const touch = std::get_if<scene::Touch>(&scene.source);
    return touch ? touch->skin : ElasticSkin();
}

// The scene with that many samples a second, so that noise and forms are those of that rate.
Plan at_rate(const Plan& plan, const PatchPlan& owner, double rate_hz) {
    Scene scene = plan.scene;
    scene.patches[static_cast<std::size_t>(&owner - plan.patches.data())].sensor.rate_hz = rate_hz;
    return make_plan(scene);
}

// A sine that rises and falls smoothly, since a corner of its envelope would be a click to PC.
struct Vibration {
    double hz;

    double rise_s() const noexcept { return std::max(0.05, 1 / hz); }
    std::int64_t cycles() const noexcept {
        return std::max<std::int64_t>(3, static_cast<std::int64_t>(0.4 * hz));
    }
    double fall_s() const noexcept { return rise_s() + static_cast<double>(cycles()) / hz; }
    double length_s() const noexcept { return fall_s() + rise_s(); }
    double at(double s) const noexcept {
        const double rise = std::clamp(std::min(s, length_s() - s) / rise_s(), 0.0, 1.0);
        return 0.5 * (1 - std::cos(std::numbers::pi * rise)) * std::sin(2 * std::numbers::pi * hz * s);
    }
};

// One afferent under a probe.
class Probed {
  public:
    Probed(const Plan& plan, std::size_t patch, std::uint32_t index, double radius_mm)
        : patch_(plan.patches[patch]),
          grid_(*plan.patches[patch_.reads].grid),
          modulus_({.tip = DiscContact::Tip::flat,
                    .radius_mm = radius_mm,
                    .load_n = DiscContact::flat_n(1, radius_mm, skin_of(plan.scene)),
                    .aperture = Aperture(grid_.pitch_mm())}),
          rate_hz_(patch_.sensor.rate_hz) {
        PatchPlan alone = patch_;
        alone.form = scene::Form::sparse;
        alone.conduction = Duration::zero();
        shard_ = make_shard(alone, index, 1, plan.scene.runtime.spikes_per_window);
    }

    // Elements before and after those under the probe are not touched, and not sampled.
    void put_probe(const Position& place) {
        DiscContact probe = modulus_;
        probe.x_mm = place.x_mm;
        probe.y_mm = place.y_mm;
        per_mm_n_.clear();
        std::size_t pressed = 0;  // as far as the last that is
        for (std::uint32_t i = 0; i < grid_.elements(); ++i) {
            const double force_n = probe.force_n(grid_.place(i));
            if (per_mm_n_.empty() && !(force_n > 0)) continue;
            if (per_mm_n_.empty()) first_ = patch_.first_element + i;
            per_mm_n_.push_back(force_n);
            if (force_n > 0) pressed = per_mm_n_.size();
        }
        per_mm_n_.resize(pressed);
        forces_n_.resize(pressed);
    }

    // The spikes, in seconds, under indentation_mm(seconds). A probe that draws back leaves the skin, where
    // pressure drives; where its changes do, it vibrates about an indentation that has been held.
    template <class Indentation>
    const std::vector<double>& spikes(double length_s, const Indentation& indentation_mm) {
        shard_->reset();
        spikes_.clear();
        TimePoint now = scene_start;
        const auto samples = static_cast<std::uint64_t>(length_s * rate_hz_);
        for (std::uint64_t i = 0; i <= samples; ++i) {
            const TimePoint time = sample_time(i, rate_hz_);
            double depth_mm = indentation_mm(seconds(time));
            if (patch_.sustained()) depth_mm = std::max(0.0, depth_mm);
            std::ranges::transform(per_mm_n_, forces_n_.begin(),
                                   [&](double force_n) { return depth_mm * force_n; });
            const Scan scan{time, first_, forces_n_};
            keys_.begin(now);
            shard_->advance(time, std::span(&scan, 1), keys_);
            for (const EventKey key : keys_.keys())
                spikes_.push_back(seconds(EventKeys::event(now, key).time));
            now = time;
        }
        return spikes_;
    }
    const std::vector<double>& press(double depth_mm, double length_s) {
        return spikes(length_s, [&](double s) { return depth_mm * std::min(1.0, s / press_rise_s); });
    }
    const std::vector<double>& vibrate(double amplitude_mm, const Vibration& vibration) {
        return spikes(vibration.length_s(), [&](double s) { return amplitude_mm * vibration.at(s); });
    }

    double rate_hz() const noexcept { return rate_hz_; }

  private:
    const PatchPlan& patch_;
    const ElementGrid& grid_;
    DiscContact modulus_;  // its load is that of an indentation of 1 mm
    double rate_hz_;
    std::unique_ptr<Shard> shard_;
    Address first_ = 0;             // of the elements under the probe
    std::vector<double> per_mm_n_;  // on each of them, at an indentation of 1 mm
    std::vector<double> forces_n_;
    EventKeys keys_;
    std::vector<double> spikes_;
};

// The smallest amplitude from `low_mm` on that is enough, if that is so at all.
template <class Enough>
std::optional<double> smallest_um(double low_mm, const Enough& enough) {
    double high_mm = deepest_mm;
    if (!enough(high_mm)) return std::nullopt;
    if (enough(low_mm)) return 1000 * low_mm;
    while (high_mm / low_mm > threshold_ratio) {
        const double tried_mm = std::sqrt(low_mm * high_mm);
        (enough(tried_mm) ? high_mm : low_mm) = tried_mm;
    }
    return 1000 * high_mm;
}

AfferentTuning::Frequency at_frequency(Probed& probed, double hz) {
    const Vibration vibration{hz};
    const auto threshold_um =
        smallest_um(least_mm, [&](double mm) { return !probed.vibrate(mm, vibration).empty(); });
    if (!threshold_um) return {hz, std::nullopt, std::nullopt};
    const auto often = [&](double mm) {
        const auto between = [&](double s) { return s >= vibration.rise_s() && s < vibration.fall_s(); };
        return std::ranges::count_if(probed.vibrate(mm, vibration), between) >= vibration.cycles();
    };
    return {hz, threshold_um, smallest_um(*threshold_um / 1000, often)};
}

AfferentTuning::Depth at_depth(Probed& probed, double depth_mm) {
    const auto& spikes = probed.press(depth_mm, 1);
    const auto within = [&](double from_s, double to_s) {
        const auto count = std::ranges::count_if(spikes, [&](double s) { return s >= from_s && s < to_s; });
        return static_cast<double>(count) / (to_s - from_s);
    };
    return {depth_mm, within(0, 0.1), within(0.5, 1)};
}

// Field and area at that depth, by a probe that is put to places on a grid around the afferent.
void find_field(AfferentTuning& tuning, Probed& probed, const Position& middle, double reach_mm,
                const std::function<void(double)>& progress) {
    const double step_mm = reach_mm / field_steps;
    const auto spikes_at = [&](int column, int row) {
        probed.put_probe({middle.x_mm + column * step_mm, middle.y_mm + row * step_mm});
        return static_cast<double>(probed.press(tuning.field_depth_um / 1000, 0.1).size());
    };
    for (int i = -field_steps; i <= field_steps; ++i) {
        tuning.field.push_back({i * step_mm, spikes_at(i, 0), spikes_at(0, i)});
        for (int k = -field_steps; k <= field_steps; ++k)
            if (spikes_at(i, k) > 0) tuning.field_mm2 += step_mm * step_mm;
        progress((i + field_steps + 1) / (2.0 * field_steps + 1));
    }
    probed.put_probe(middle);
}

// Beyond this distance the field ends, and with it what the probe can do.
double reach_mm(const PatchPlan& patch, const ElementGrid& grid, std::uint32_t index, const Position& middle,
                double radius_mm) {
    double reach = 0;
    if (!patch.fields.is_one_each())
        for (const auto& weight : patch.fields.row(index))
            reach = std::max(reach, std::hypot(grid.place(weight.element).x_mm - middle.x_mm,
                                               grid.place(weight.element).y_mm - middle.y_mm));
    return reach + Aperture::reach * grid.pitch_mm() + radius_mm;
}

AfferentTuning probe(const Plan& plan, std::size_t patch, std::uint32_t index, AfferentTuning tuning,
                     const TuningOptions& options) {
    // Roughly the time that each part takes.
    constexpr double of_field = 0.3;
    constexpr double of_frequencies = 0.9;
    const auto progress = [&](double fraction) {
        if (options.progress) options.progress(fraction);
    };
    const PatchPlan& planned = plan.patches[patch];
    const ElementGrid& grid = *plan.patches[planned.reads].grid;
    const Position middle{tuning.place.x_mm - planned.centre.x_mm, tuning.place.y_mm - planned.centre.y_mm};
    Probed probed(plan, patch, index, options.radius_mm);
    probed.put_probe(middle);
    tuning.rate_hz = probed.rate_hz();
    tuning.threshold_um = smallest_um(least_mm, [&](double mm) { return !probed.press(mm, 0.1).empty(); });
    if (tuning.threshold_um) {
        tuning.field_depth_um = std::min(1000 * deepest_mm, field_thresholds * *tuning.threshold_um);
        find_field(tuning, probed, middle, reach_mm(planned, grid, index, middle, options.radius_mm),
                   [&](double fraction) { progress(of_field * fraction); });
    }
    for (const double hz : frequencies_hz) {
        if (hz * least_samples_a_cycle > tuning.rate_hz) break;
        tuning.frequencies.push_back(at_frequency(probed, hz));
        progress(std::lerp(of_field, of_frequencies,
                           static_cast<double>(tuning.frequencies.size()) / std::size(frequencies_hz)));
    }
    for (const double depth_mm : depths_mm) tuning.depths.push_back(at_depth(probed, depth_mm));
    const auto& spikes = probed.press(options.hold_mm, 5);
    for (std::size_t i = 1; i < spikes.size(); ++i)
        if (spikes[i - 1] >= 0.5) tuning.intervals_ms.push_back(1000 * (spikes[i] - spikes[i - 1]));
    progress(1);
    return tuning;
}

// The tuning of `count` afferents of a patch, from its `first` on.
Result<std::vector<AfferentTuning>> tunings_of(const Plan& plan, const PatchPlan& patch, std::uint32_t first,
                                               std::uint32_t count, const TuningOptions& options) {
    const PatchPlan& owner = plan.patches[patch.reads];
    if (!owner.grid)
        return not_allowed("patch \"" + patch.name +
                           "\" has no places that a probe could touch: it has no outline");
    if (!(options.radius_mm > 0) || !(options.hold_mm > 0) || (options.rate_hz && !(*options.rate_hz > 0)))
        return not_allowed("radius, depth and rate must be above 0");
    const auto index = static_cast<std::size_t>(&patch - plan.patches.data());
    const Population population = population_of(plan);
    std::vector<AfferentTuning> all;
    try {
        const Plan probed = at_rate(plan, owner, options.rate_hz.value_or(owner.sensor.rate_hz));
        TuningOptions one = options;
        if (options.progress)
            one.progress = [&](double fraction) {
                options.progress((static_cast<double>(all.size()) + fraction) / count);
            };
        for (std::uint32_t i = first; i < first + count; ++i)
            all.push_back(probe(probed, index, i,
                                {.address = patch.first + i,
                                 .patch = patch.name,
                                 .kind = population.patches[index].kind,
                                 .place = population.afferents[patch.first + i].place.value(),
                                 .radius_mm = options.radius_mm,
                                 .hold_mm = options.hold_mm},
                                one));
    } catch (const SpikeStormError& storm) {
        return not_allowed(storm.what());
    } catch (const SceneError& refused) {
        return not_allowed(refused.what());
    }
    return all;
}

}  // namespace

Result<AfferentTuning> tuning_of(const Plan& plan, Address address, const TuningOptions& options) {
    if (address >= plan.addresses)
        return not_allowed("there is no address " + std::to_string(address) + ": the scene has " +
                           std::to_string(plan.addresses));
    const PatchPlan& patch =
        *std::prev(std::ranges::upper_bound(plan.patches, address, {}, &PatchPlan::first));
    auto one = tunings_of(plan, patch, address - patch.first, 1, options);
    if (!one) return one.error();
    return std::move(one.value().front());
}

Result<std::vector<AfferentTuning>> tuning_of_patch(const Plan& plan, const std::string& patch,
                                                    const TuningOptions& options) {
    const auto found = std::ranges::find(plan.patches, patch, &PatchPlan::name);
    if (found == plan.patches.end()) return not_allowed("there is no patch \"" + patch + "\"");
    return tunings_of(plan, *found, 0, found->afferents(), options);
}

}  // namespace afferent
