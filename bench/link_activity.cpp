#include "bench/link_activity.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <stdexcept>
#include <utility>
#include <variant>

#include "afferent/engine/coprocessor.hpp"
#include "afferent/nodes/run.hpp"
#include "afferent/nodes/sample_source.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

constexpr Duration window = 5ms;
constexpr double full_scale_counts = 4095;

// Its samples are given from outside.
Scene without_link(const Scene& scene) {
    Scene alone = scene;
    alone.source = scene::SimulatedHand();
    alone.link = {};
    alone.gain.accept_unreachable_limit = true;  // no hand moves by it
    return alone;
}

LinkActivity activity_of(const Plan& plan, std::string name, Duration duration, SampleSource& source,
                         const GripForce& grip_force_n) {
    LinkActivity activity{.name = std::move(name),
                          .elements = plan.elements,
                          .addresses = plan.addresses,
                          .duration = duration};
    activity.newtons_per_count = plan.patches[0].sensor.full_scale_n / full_scale_counts;
    activity.noise_counts = plan.patches[0].sensor.noise_counts;
    for (const PatchPlan& patch : plan.patches)
        activity.neurons.push_back({patch.afferents(), neuron_law(patch.neuron)});
    std::size_t scans = 0;
    TimePoint last_scan = TimePoint::min();
    Coprocessor coprocessor(plan);
    for (TimePoint until = scene_start + window; until <= scene_start + duration; until += window) {
        for (auto due = source.next(); due && due->time < until; due = source.next()) {
            const auto scan = source.take(grip_force_n(due->time));
            if (!scan) throw std::runtime_error(source.refusal().text);
            coprocessor.push(scan.value());
            if (std::exchange(last_scan, due->time) != due->time) ++scans;
            for (const double force_n : scan.value().forces_n)
                activity.counts.push_back(static_cast<std::uint16_t>(
                    std::clamp(std::round(force_n / activity.newtons_per_count), 0.0, full_scale_counts)));
        }
        const auto events = coprocessor.advance(until - Duration(1));
        activity.events.insert(activity.events.end(), events.begin(), events.end());
    }
    // Only patches that are sampled together give scans that are rows of counts.
    if (scans == 0 || activity.counts.size() != scans * activity.elements)
        throw std::runtime_error("the patches of the scene are not sampled together");
    activity.frame_interval = duration / static_cast<Duration::rep>(scans);
    return activity;
}

}  // namespace

Scene scaled_scene(const Scene& scene, std::uint32_t elements) {
    Scene scaled = without_link(scene);
    const std::uint32_t own_elements = make_plan(scene, Commands::recorded).elements;
    if (elements == own_elements) return scaled;
    std::mt19937_64 random(1);
    // A spread of shares of a third of their mean, as curved fingertips give.
    std::lognormal_distribution<double> share(0, 0.35);
    std::vector<double> shares(elements);
    double sum = 0;
    for (double& value : shares) sum += value = share(random);
    for (double& value : shares) value /= sum;
    scaled.patches.clear();
    std::uint32_t first = 0;
    std::uint32_t finished = 0;
    for (const char* finger : {"thumb", "index", "middle"}) {
        const auto end = static_cast<std::uint32_t>(std::uint64_t{elements} * ++finished / 3);
        scene::Patch patch = scene.patches.front();
        patch.name = finger;
        patch.elements = end - first;
        patch.share.assign(shares.begin() + first, shares.begin() + end);
        patch.field.clear();
        // One element feels that much less, and is built for it. Its curve would have to be scaled likewise.
        patch.sensor.full_scale_n *= static_cast<double>(own_elements) / elements;
        patch.sensor.force_resistance.reset();
        patch.sensor.calibration.clear();
        patch.sensor.dead_element.clear();
        patch.sensor.stuck_element.clear();
        scaled.patches.push_back(std::move(patch));
        // The further afferents of its elements.
        for (const scene::Patch& other : scene.patches)
            if (other.elements_of == scene.patches.front().name) {
                scaled.patches.push_back(other);
                scaled.patches.back().name = finger + (", " + other.name);
                scaled.patches.back().elements_of = finger;
                scaled.patches.back().field.clear();
            }
        first = end;
    }
    return scaled;
}

LinkActivity poisson_activity(std::uint32_t elements, double rate_hz, Duration duration, std::uint64_t seed) {
    LinkActivity activity{
        .name = "poisson20", .elements = elements, .addresses = elements, .duration = duration};
    activity.neurons = {{elements, {}}};
    std::mt19937_64 random(seed);
    std::poisson_distribution<std::uint64_t> count(rate_hz * elements * seconds(duration));
    activity.events.resize(count(random));
    for (Event& event : activity.events)
        event = {scene_start + Duration(random() % static_cast<std::uint64_t>(duration.count())),
                 static_cast<Address>(random() % elements)};
    std::sort(activity.events.begin(), activity.events.end());
    return activity;
}

LinkActivity grip_activity(const Scene& scene, std::uint32_t elements, std::string name, Duration duration,
                           const GripForce& grip_force_n) {
    const Scene scaled = scaled_scene(scene, elements);
    const Plan plan = make_plan(scaled);
    const Duration length = std::min(duration, elements > 10'000 ? Duration(4s) : duration) / window * window;
    ClockedSource source(plan);
    LinkActivity activity = activity_of(plan, std::move(name), length, source, grip_force_n);
    activity.grip = {scaled, grip_force_n};
    return activity;
}

std::optional<LinkActivity> recorded_activity(const Scene& scene) {
    const scene::Table* const table = force_table(scene.source);
    if (!table) return std::nullopt;
    const Plan plan = make_plan(without_link(scene));
    auto source = TableSource::open(plan, *table);
    if (!source) throw std::runtime_error(source.error().text);
    return activity_of(plan, "recording", (scene.end() - scene_start) / window * window, *source.value(),
                       [](TimePoint) { return 0; });
}

GripForce grip_force_of(const Scene& scene) {
    auto trace = std::make_shared<std::vector<std::pair<TimePoint, double>>>();
    const Plan plan = make_plan(scene);
    const auto run = Run::open(plan, {.events = [](auto) {},
                                      .step =
                                          [trace](const ControllerStep& step) {
                                              trace->emplace_back(step.time, step.true_force_n.value_or(0));
                                          }});
    if (!run) throw std::runtime_error(run.error().text);
    while (!run.value()->done())
        if (const auto stepped = run.value()->do_next(); !stepped)
            throw std::runtime_error(stepped.error().text);
    return [trace](TimePoint time) {
        const auto after = std::partition_point(trace->begin(), trace->end(),
                                                [time](const auto& point) { return point.first <= time; });
        return after == trace->begin() ? 0.0 : std::prev(after)->second;
    };
}

}  // namespace afferent
