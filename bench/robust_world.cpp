#include "bench/robust_world.hpp"

#include <algorithm>
#include <deque>
#include <utility>

#include "afferent/engine/coprocessor.hpp"
#include "afferent/nodes/patch_sensors.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

TimePoint time_of(std::size_t step) { return scene_start + static_cast<Duration::rep>(step) * Touch::step; }

// The plan constructs the scene's own decoder, which is not used here; this one is cheap to construct.
Plan open_loop(Scene scene) {
    scene.decoder.kind = scene::Inversion();
    scene.source = scene::SimulatedHand();
    scene.link = {};
    return make_plan(scene, Commands::recorded);
}

// The readings of a world's elements, scan by scan.
class Elements {
  public:
    explicit Elements(const World& world) : world_(world), told_n_(world.elements()) {
        for (const PatchPlan& patch : world.made.patches) sensors_.emplace_back(patch, world.made.scene.seed);
    }

    // The sum over all elements, in N.
    std::span<const double> feel(TimePoint time, std::uint64_t index) {
        for (std::size_t p = 0; p < sensors_.size(); ++p) {
            const PatchPlan& patch = world_.made.patches[p];
            felt_n_.clear();
            for (std::uint32_t i = 0; i < patch.elements(); ++i) felt_n_.push_back(true_n(patch, i, time));
            const auto told_n = sensors_[p].feel_elements(0, felt_n_, index);
            for (std::uint32_t i = 0; i < patch.elements(); ++i) {
                const std::size_t element = patch.first_element + i;
                told_n_[element] = time < world_.dies[element] ? world_.gain[element] * told_n[i] : 0;
            }
        }
        return told_n_;
    }

  private:
    double true_n(const PatchPlan& patch, std::uint32_t i, TimePoint time) const {
        const std::size_t element = patch.first_element + i;
        return world_.element_n.empty() ? world_.share[element] * world_.force_n(time)
                                        : world_.element_n[element](time);
    }

    const World& world_;
    std::deque<PatchSensors> sensors_;
    std::vector<double> felt_n_, told_n_;
};

}  // namespace

World::World(std::string called, const Scene& scene, GripForce grip_n, Duration length)
    : name(std::move(called)),
      force_n(std::move(grip_n)),
      duration(length),
      told(open_loop(scene)),
      afferents(told.controller->afferents),
      made(told),
      gain(told.elements, 1),
      dies(told.elements, TimePoint::max()) {
    for (const PatchPlan& patch : told.patches)
        share.insert(share.end(), patch.share.begin(), patch.share.end());
}

TimePoint World::in_the_grip(double part) const {
    double largest_n = 0;
    for (TimePoint time = scene_start; time < scene_start + duration; time += Touch::step)
        largest_n = std::max(largest_n, force_n(time));
    TimePoint begin = scene_start, found = scene_start;
    Duration longest{};
    for (TimePoint time = scene_start; time < scene_start + duration; time += Touch::step) {
        if (force_n(time) < 0.3 * largest_n) begin = time;
        if (time - begin <= longest) continue;
        longest = time - begin;
        found = begin + from_seconds(part * seconds(longest));
    }
    return found;
}

TouchedForce touched_force(const World& world) {
    TouchedForce force;
    force.afferents = world.afferents;
    LinkActivity& activity = force.activity;
    activity.elements = world.made.elements;
    activity.addresses = world.made.addresses;
    activity.duration = world.duration;
    const scene::Sensor& sensor = world.made.patches.front().sensor;
    activity.frame_interval = from_seconds(1 / sensor.rate_hz);

    double share_told = 0;
    for (const PatchPlan& patch : world.told.patches)
        for (const double share : patch.share) share_told += share;
    Coprocessor coprocessor(world.made);
    Elements elements(world);
    std::vector<double> sensed_n;  // by scan
    const auto advance = [&](TimePoint until) {
        const auto events = coprocessor.advance(until);
        activity.events.insert(activity.events.end(), events.begin(), events.end());
    };
    for (TimePoint time = scene_start; time < scene_start + world.duration; time += activity.frame_interval) {
        const auto told_n = elements.feel(time, sensed_n.size());
        double sum_n = 0;
        for (const double n : told_n) sum_n += n;
        sensed_n.push_back(sum_n / share_told);
        coprocessor.push({time, 0, told_n});
        advance(time + activity.frame_interval - Duration(1));
    }
    const auto steps = static_cast<std::size_t>(world.duration / Touch::step);
    for (std::size_t k = 0; k < steps; ++k) {
        force.true_n.push_back(world.force_n(time_of(k)));
        const auto scan = static_cast<std::size_t>((time_of(k) - scene_start) / activity.frame_interval);
        force.sensed_n.push_back(sensed_n[std::min(scan, sensed_n.size() - 1)]);
    }
    return force;
}

std::vector<bool> judged(const World& world, const std::vector<double>& true_n) {
    constexpr std::size_t slope_steps = 10, after_steps = 50;
    std::vector<bool> judged(true_n.size());
    std::size_t until = 0;
    for (std::size_t k = 0; k < true_n.size(); ++k) {
        if (k >= slope_steps &&
            true_n[k] - true_n[k - slope_steps] < -10 * seconds(slope_steps * Touch::step))
            until = k + after_steps;
        judged[k] = time_of(k) >= world.judged_from && (!world.judged_in_fast_release || k < until);
    }
    return judged;
}

}  // namespace afferent
