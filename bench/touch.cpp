#include "bench/touch.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>
#include <variant>

#include "afferent/io/files/table.hpp"
#include "afferent/runtime/piecewise_linear.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

constexpr Duration longest = 20s;

struct ForceAt {
    double time_s;
    double force_n;
};

GripForce linear(std::vector<ForceAt> points) {
    return [points = std::move(points)](TimePoint time) {
        return std::max(0.0, interpolate(points, &ForceAt::time_s, &ForceAt::force_n, seconds(time)));
    };
}

std::vector<double> noise_of(const scene::Sensor& parameters, double newtons_per_count) {
    Sensor::Parameters still = parameters;
    still.hysteresis = 0;
    const Sensor sensor(still);
    const double noise_counts = std::sqrt(parameters.noise_counts * parameters.noise_counts + 1.0 / 12);
    std::vector<double> noise_n(4096);
    for (std::size_t count = 0; count < noise_n.size(); ++count) {
        Sensor::State state;
        const double reading = sensor.counts(state, static_cast<double>(count) * newtons_per_count, 0);
        const double low = std::max(0.0, reading - 1);
        const double high = std::min(sensor.highest_count(), reading + 1);
        const double slope = (sensor.force_n(high) - sensor.force_n(low)) / (high - low);
        noise_n[count] = std::hypot(slope * noise_counts, newtons_per_count / std::sqrt(12.0));
    }
    return noise_n;
}

// By step, from what the sensors read of the whole force in each scan.
std::vector<double> sensed_by_step(const TouchedForce& force, std::size_t steps) {
    const LinkActivity& activity = force.activity;
    const double share = std::accumulate(force.share.begin(), force.share.end(), 0.0);
    std::vector<ForceAt> scans(activity.scans());
    for (std::size_t i = 0; i < scans.size(); ++i) {
        const auto scan = activity.scan(i);
        const auto counts = std::accumulate(scan.begin(), scan.end(), std::uint64_t{0});
        scans[i] = {seconds(activity.frame_interval) * static_cast<double>(i),
                    static_cast<double>(counts) * activity.newtons_per_count / share};
    }
    std::vector<double> sensed_n(steps);
    for (std::size_t k = 0; k < steps; ++k)
        sensed_n[k] = interpolate(scans, &ForceAt::time_s, &ForceAt::force_n,
                                  seconds(Touch::step) * static_cast<double>(k));
    return sensed_n;
}

LinkActivity joined(const std::vector<TouchedForce>& forces) {
    LinkActivity all = forces.front().activity;
    if (forces.size() == 1) return all;
    all.elements = all.addresses = 0;
    all.neurons.clear();
    all.events.clear();
    all.counts.clear();
    for (const TouchedForce& force : forces) {
        all.neurons.insert(all.neurons.end(), force.activity.neurons.begin(), force.activity.neurons.end());
        for (const Event& event : force.activity.events)
            all.events.push_back({event.time, all.addresses + event.address});
        all.elements += force.activity.elements;
        all.addresses += force.activity.addresses;
    }
    std::sort(all.events.begin(), all.events.end());
    for (std::size_t i = 0; i < forces.front().activity.scans(); ++i)
        for (const TouchedForce& force : forces) {
            const auto scan = force.activity.scan(i);
            all.counts.insert(all.counts.end(), scan.begin(), scan.end());
        }
    return all;
}

Scene with_hysteresis(Scene scene, double hysteresis) {
    for (scene::Patch& patch : scene.patches) patch.sensor.hysteresis = hysteresis;
    return scene;
}

std::optional<RecordedForces> recorded_forces_of(const std::filesystem::path& file) {
    auto read = read_table(file);
    const Table* table = std::get_if<Table>(&read);
    const auto in_newtons = [](const std::string& column) { return column.ends_with("_n"); };
    if (!table || !std::all_of(table->columns.begin(), table->columns.end(), in_newtons)) return std::nullopt;
    RecordedForces forces{
        file.stem().string(), std::min<Duration>(table->times.back() - scene_start, longest), {}};
    for (std::size_t column = 0; column < table->columns.size(); ++column) {
        std::vector<ForceAt> points;
        for (std::size_t row = 0; row < table->rows(); ++row)
            points.push_back({seconds(table->times[row]), table->row(row)[column]});
        forces.columns.push_back(linear(std::move(points)));
    }
    return forces;
}

void add_table(const RecordedForces& table, std::vector<Touch>& found) {
    if (table.columns.size() > 1) {
        std::vector<TouchedForce> touched;
        for (const GripForce& force : table.columns)
            touched.push_back(touched_force(plain_scene({1}, 5, 5), table.duration, force));
        found.emplace_back(table.name, std::move(touched));
        return;
    }
    const auto one = [&](const std::string& what, const Scene& scene) {
        found.emplace_back(what, std::vector{touched_force(scene, table.duration, table.columns.front())});
    };
    one(table.name, plain_scene({1}, 50, 20));
    one(table.name, plain_scene(nine_shares, 10, 20));
    one(table.name + "-equal", plain_scene(std::vector<double>(9, 1.0 / 9), 10, 20));
}

// 40 patches of 25 elements; four of them feel the force, each a part of it and 0.4 s after the one before.
Touch a_tenth_touched(const Scene& scene, Duration duration, const GripForce& force_n) {
    Scene patch = scaled_scene(scene, 25);
    std::vector<TouchedForce> forces;
    for (int i = 0; i < 40; ++i) {
        patch.seed = scene.seed + static_cast<std::uint64_t>(i);
        forces.push_back(touched_force(patch, duration, [&](TimePoint time) {
            const TimePoint at = time - (i / 10) * 400ms;
            return i % 10 != 0 || at < scene_start ? 0.0 : (1 - 0.2 * (i / 10)) * force_n(at);
        }));
    }
    return {"tenth-touched", std::move(forces)};
}

}  // namespace

Scene plain_scene(std::vector<double> share, double full_scale_n, double tuned_n) {
    Scene scene;
    scene::Patch patch{.name = "patch", .elements = static_cast<std::uint32_t>(share.size())};
    patch.sensor.full_scale_n = full_scale_n;
    patch.neuron.tuning = {.rate_hz = 100, .force_n = tuned_n, .begin_force_n = 0.015 * tuned_n};
    patch.share = std::move(share);
    scene.patches = {patch};
    return scene;
}

std::vector<RecordedForces> recorded_forces(const std::filesystem::path& folder) {
    std::error_code absent;
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder, absent))
        if (entry.path().extension() == ".csv") files.push_back(entry.path());
    if (files.empty())
        std::cerr << folder.string() << ": no recorded forces here, which are left out (--data)\n";
    std::sort(files.begin(), files.end());
    std::vector<RecordedForces> forces;
    for (const auto& file : files)
        if (auto table = recorded_forces_of(file)) forces.push_back(std::move(*table));
    return forces;
}

bool TouchedForce::touched() const noexcept { return *std::max_element(true_n.begin(), true_n.end()) > 0; }

Touch::Touch(std::string called, std::vector<TouchedForce> together)
    : name(std::move(called)), forces(std::move(together)), activity(joined(forces)) {}

std::size_t Touch::touched() const noexcept {
    return static_cast<std::size_t>(std::count_if(forces.begin(), forces.end(),
                                                  [](const TouchedForce& force) { return force.touched(); }));
}

double Touch::wander_n2_per_s() const noexcept {
    const auto scan = static_cast<std::size_t>(std::max<Duration::rep>(1, activity.frame_interval / step));
    double sum = 0;
    for (const TouchedForce& force : forces) {
        if (!force.touched()) continue;
        for (std::size_t k = scan; k < force.true_n.size(); k += scan)
            sum += std::pow(force.true_n[k] - force.true_n[k - scan], 2);
    }
    return sum / static_cast<double>(touched()) / activity.seconds_long();
}

TouchedForce touched_force(const Scene& scene, Duration duration, const GripForce& force_n) {
    TouchedForce force;
    const std::uint32_t elements = make_plan(scene, Commands::recorded).elements;
    const Plan plan = make_plan(scaled_scene(scene, elements), Commands::recorded);
    force.activity = grip_activity(scene, elements, "", duration, force_n);
    force.afferents = plan.controller->afferents;
    for (const PatchPlan& patch : plan.patches)
        if (patch.owns_elements)
            force.share.insert(force.share.end(), patch.share.begin(), patch.share.end());
    force.noise_n = noise_of(plan.patches.front().sensor, force.activity.newtons_per_count);
    const auto steps = static_cast<std::size_t>(force.activity.duration / Touch::step);
    for (std::size_t k = 0; k < steps; ++k)
        force.true_n.push_back(force_n(scene_start + static_cast<Duration::rep>(k) * Touch::step));
    force.sensed_n = sensed_by_step(force, steps);
    return force;
}

std::vector<Touch> touches(const TouchOptions& options) {
    std::vector<Touch> found;
    const auto one = [&](const std::string& name, const Scene& scene, const GripForce& force_n) -> Touch& {
        std::vector<TouchedForce> forces{
            touched_force(scene, std::min<Duration>(scene.end() - scene_start, longest), force_n)};
        return found.emplace_back(name, std::move(forces));
    };
    for (const std::string& file : options.scenes) {
        const Scene scene = Scene::from_file(file);
        one(std::filesystem::path(file).stem().string(), scene, grip_force_of(scene));
    }
    if (!options.scenes.empty()) return found;

    const Scene grasp = Scene::from_file(options.examples / "grasp.txtpb");
    const GripForce grasped = grip_force_of(grasp);
    one("grasp", grasp, grasped);
    one("grasp-unmodelled", grasp, grasped);
    found.back().forces.front().hysteresis_is_known = false;
    found.back().forces.front().afferents.hysteresis = 0;
    one("grasp-no-hysteresis", with_hysteresis(grasp, 0), grasped);
    const Scene paper = Scene::from_file(options.examples / "paper.txtpb");
    one("paper", paper, grip_force_of(paper));
    if (options.quick) return found;
    for (const RecordedForces& table : recorded_forces(options.data)) add_table(table, found);
    found.push_back(a_tenth_touched(grasp, grasp.end() - scene_start, grasped));
    return found;
}

}  // namespace afferent
