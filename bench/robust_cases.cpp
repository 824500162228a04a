#include "bench/robust_cases.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <utility>

#include "afferent/runtime/piecewise_linear.hpp"

namespace afferent {
namespace {

using Worlds = std::vector<World>;
using Change = std::function<void(World&, unsigned)>;

bool several_columns(const RecordedForces& table) { return table.columns.size() > 1; }

// The grasp's elements with linear sensors. One encoder and one neuron serve all, so that the elements with
// large shares fire most; at 20 N 100 Hz in the mean.
Scene three_fingers(double full_scale_n) {
    Scene scene = plain_scene(nine_shares, full_scale_n, 20);
    const PatchPlan alike = make_plan(scene, Commands::recorded).patches.front();
    scene.patches.front().encoder = scene::Sustained{alike.gain(), alike.bias_mv()};
    scene.patches.resize(3, scene.patches.front());
    for (std::size_t finger = 0; finger < 3; ++finger) {
        scene::Patch& patch = scene.patches[finger];
        const auto share = nine_shares.begin() + static_cast<std::ptrdiff_t>(3 * finger);
        patch.name = std::array{"thumb", "index", "middle"}[finger];
        patch.elements = 3;
        patch.share.assign(share, share + 3);
    }
    return scene;
}

// Contact after half a second, a rise within 0.3 s, a hold, and a release within 0.3 s.
GripForce step_to(double force_n, double hold_s = 4) {
    struct Point {
        double time_s, force_n;
    };
    const std::vector<Point> points{
        {0, 0}, {0.5, 0}, {0.8, force_n}, {0.8 + hold_s, force_n}, {1.1 + hold_s, 0}, {2 + hold_s, 0}};
    return [points](TimePoint time) {
        return interpolate(points, &Point::time_s, &Point::force_n, seconds(time));
    };
}

// ---- the grips, as told ----

World grasp(const RobustInput& input) {
    return {"grasp", input.grasp, input.grasped_n, input.grasp.end() - scene_start};
}
// The grasp, a plain grip and the recorded ones, on nine elements of three fingers.
Worlds grips(const RobustInput& input) {
    Worlds worlds{grasp(input), {"held 35 N", three_fingers(10), step_to(35, 14), 16s}};
    for (const RecordedForces& table : input.recorded)
        if (!several_columns(table))
            worlds.push_back({table.name, three_fingers(10), table.columns.front(), table.duration});
    return worlds;
}

GripForce sum_of(const std::vector<GripForce>& columns) {
    return [columns](TimePoint time) {
        double sum_n = 0;
        for (const GripForce& column : columns) sum_n += column(time);
        return sum_n;
    };
}

// The best constant shares of the columns: least squares of each on their sum.
std::vector<double> best_shares(const RecordedForces& table) {
    std::vector<double> share(table.columns.size());
    double squares = 0;
    for (TimePoint time = scene_start; time < scene_start + table.duration; time += 10ms) {
        const double sum_n = sum_of(table.columns)(time);
        squares += sum_n * sum_n;
        for (std::size_t i = 0; i < share.size(); ++i) share[i] += table.columns[i](time) * sum_n;
    }
    for (double& each : share) each /= squares;
    return share;
}

// The columns of a table as the elements of one patch, which feel the best constant shares of their sum.
Worlds columns_as_elements(const RobustInput& input) {
    Worlds worlds;
    for (const RecordedForces& table : input.recorded)
        if (several_columns(table))
            worlds.push_back(
                {table.name, plain_scene(best_shares(table), 5, 10), sum_of(table.columns), table.duration});
    return worlds;
}

Worlds columns_as_they_are(const RobustInput& input) {
    Worlds worlds = columns_as_elements(input);
    for (World& world : worlds)
        world.element_n = std::ranges::find(input.recorded, world.name, &RecordedForces::name)->columns;
    return worlds;
}

Worlds columns_by_themselves(const RobustInput& input) {
    Worlds worlds;
    for (const RecordedForces& table : input.recorded)
        for (const GripForce& column : table.columns)
            worlds.push_back({table.name,
                              several_columns(table) ? plain_scene({1}, 5, 5) : plain_scene({1}, 50, 20),
                              column, table.duration});
    return worlds;
}

Worlds beyond_full_scale(const RobustInput& input) {
    Scene one = input.paper;
    one.patches.front().sensor.full_scale_n = 25;
    return {
        {"one of 25 N under 28 N", one, step_to(28), 6s},
        {"nine of 1.2 N under 40 N", three_fingers(1.2), step_to(40), 6s},
        {"three of 4 N under 20 N", plain_scene(std::vector<double>(3, 1.0 / 3), 4, 20), step_to(20), 6s}};
}

Worlds sine(const RobustInput&) {
    return {{"sine", three_fingers(10),
             [](TimePoint time) {
                 return step_to(10)(time) * (1 + 0.5 * std::sin(10 * std::numbers::pi * seconds(time)));
             },
             6s}};
}

// ---- how the worlds differ from what is told ----

void nothing(World&, unsigned) {}

Change element_gains(double sd) {
    return [sd](World& world, unsigned draw) {
        std::mt19937_64 random(draw);
        std::normal_distribution<double> gain(1, sd);
        for (double& each : world.gain) each = gain(random);
    };
}

Change all_gains(double factor) {
    return [factor](World& world, unsigned) { world.gain.assign(world.elements(), factor); };
}

// Three elements make a finger.
bool is_of(unsigned finger, std::size_t element) { return element / 3 == finger; }

Change finger_without_load(unsigned finger) {
    return [finger](World& world, unsigned) {
        double rest = 0;
        for (std::size_t i = 0; i < world.elements(); ++i)
            if (!is_of(finger, i)) rest += world.share[i];
        for (std::size_t i = 0; i < world.elements(); ++i)
            world.share[i] = is_of(finger, i) ? 0 : world.share[i] / rest;
    };
}

Change finger_with_dead_sensors(unsigned finger) {
    return [finger](World& world, unsigned) {
        for (std::size_t i = 0; i < world.elements(); ++i)
            if (is_of(finger, i)) world.dies[i] = scene_start;
    };
}

enum class Which { largest, smallest, random };

std::vector<std::size_t> four(const World& world, Which which, unsigned draw) {
    std::vector<std::size_t> order(world.elements());
    std::iota(order.begin(), order.end(), std::size_t{0});
    if (which == Which::random)
        std::shuffle(order.begin(), order.end(), std::mt19937_64(draw));
    else
        std::stable_sort(order.begin(), order.end(), [&](std::size_t one, std::size_t other) {
            return which == Which::largest ? world.share[one] > world.share[other]
                                           : world.share[one] < world.share[other];
        });
    order.resize(4);
    return order;
}

Change dead_from_the_start(Which which) {
    return [which](World& world, unsigned draw) {
        for (const std::size_t element : four(world, which, draw)) world.dies[element] = scene_start;
    };
}

// Early and late in the grip; half a second is allowed to notice.
Change dying(Which which) {
    return [which](World& world, unsigned draw) {
        const TimePoint death = world.in_the_grip(std::array{0.5, 0.1, 0.3, 0.7}[draw % 4]);
        for (const std::size_t element : four(world, which, draw)) world.dies[element] = death;
        world.judged_from = death + 500ms;
    };
}

Change neuron(double LifParameters::*constant, double factor) {
    return [constant, factor](World& world, unsigned) {
        for (PatchPlan& patch : world.made.patches) {
            auto& parameters = std::get<LifParameters>(patch.neuron);
            parameters.*constant *= factor;
        }
    };
}

void hysteresis_untold(World& world, unsigned) {
    world.afferents.hysteresis = 0;
    for (PatchPlan& patch : world.made.patches) patch.sensor.hysteresis = 0.08;
}

Change forces_times(double factor) {
    return [factor](World& world, unsigned) {
        Scene scene = world.told.scene;
        for (scene::Patch& patch : scene.patches) {
            patch.sensor.full_scale_n *= factor;
            if (patch.sensor.force_resistance) patch.sensor.force_resistance->half_force_n *= factor;
            patch.neuron.tuning.force_n *= factor;
            patch.neuron.tuning.begin_force_n *= factor;
            auto& gain = std::get<scene::Sustained>(patch.encoder).gain_mv_per_n;
            if (gain) *gain /= factor;
        }
        const GripForce unscaled_n = world.force_n;
        world = World(
            world.name, scene, [=](TimePoint time) { return factor * unscaled_n(time); }, world.duration);
        world.unit_n = factor;
    };
}

void lost_packets(World& world, unsigned draw) {
    world.lost = 0.1;
    world.draw = draw + 1;
}

// Begins at 2 N of grip force and has its full amplitude from 4 N on.
void tremor(World& world, unsigned) {
    const GripForce steady_n = world.force_n;
    world.force_n = [=](TimePoint time) {
        const double force_n = steady_n(time);
        return force_n + 1.5 * std::clamp((force_n - 2) / 2, 0.0, 1.0) *
                             std::sin(20 * std::numbers::pi * seconds(time));
    };
}

void fast_release(World& world, unsigned) { world.judged_in_fast_release = true; }

}  // namespace

RobustInput robust_input(const std::filesystem::path& examples, const std::filesystem::path& data) {
    Scene grasp = Scene::from_file(examples / "grasp.txtpb");
    Scene paper = Scene::from_file(examples / "paper.txtpb");
    GripForce grasped_n = grip_force_of(grasp);
    return {std::move(grasp), std::move(paper), std::move(grasped_n), recorded_forces(data)};
}

const std::vector<RobustCase>& robust_cases() {
    static const std::vector<RobustCase> cases{
        {"as_told", "nothing", grips, nothing, 1, {}, true},
        {"shares_as_told", "nothing, five elements", columns_as_elements, nothing},
        {"full_scale", "sensors at full scale", beyond_full_scale, nothing, 1, {}, true},
        {"shares", "shares that wander, five elements", columns_as_they_are, nothing, 1,
         Uncertainty{.share = 0.3}},
        {"gains_5", "gains of the elements, 5 %", grips, element_gains(0.05), 4, {}, true},
        {"gains_10", "gains of the elements, 10 %", grips, element_gains(0.1), 4, Uncertainty{.gain = 0.1}},
        {"unloaded_thumb", "the thumb does not touch", grips, finger_without_load(0)},
        {"unloaded_index", "the index does not touch", grips, finger_without_load(1), 1, {}, true},
        {"unloaded_middle", "the middle finger does not touch", grips, finger_without_load(2)},
        {"dead_thumb", "the thumb's sensors are dead", grips, finger_with_dead_sensors(0)},
        {"dead_index", "the index's sensors are dead", grips, finger_with_dead_sensors(1)},
        {"dead_middle", "the middle finger's sensors are dead", grips, finger_with_dead_sensors(2)},
        {"dead_largest",
         "the four largest are dead from the start",
         grips,
         dead_from_the_start(Which::largest),
         1,
         {},
         true},
        {"dead_smallest", "the four smallest are dead from the start", grips,
         dead_from_the_start(Which::smallest)},
        {"dying_largest", "the four largest die in the grip", grips, dying(Which::largest), 4, {}, true},
        {"dying_smallest", "the four smallest die in the grip", grips, dying(Which::smallest), 4},
        {"dying_random", "four die in the grip", grips, dying(Which::random), 4},
        {"all_gains_low", "all gains, 10 % low", grips, all_gains(0.9), 1, Uncertainty{.common_gain = 0.1},
         true},
        {"all_gains_high", "all gains, 10 % high", grips, all_gains(1.1), 1, Uncertainty{.common_gain = 0.1}},
        {"tau_g_long", "tau_g, 20 % long", grips, neuron(&LifParameters::tau_g_ms, 1.2), 1,
         Uncertainty{.adaptation = 0.2}},
        {"tau_g_short", "tau_g, 20 % short", grips, neuron(&LifParameters::tau_g_ms, 0.8), 1,
         Uncertainty{.adaptation = 0.2}},
        {"delta_g_high", "delta_g, 20 % high", grips, neuron(&LifParameters::delta_g, 1.2), 1,
         Uncertainty{.adaptation = 0.2}},
        {"delta_g_low", "delta_g, 20 % low", grips, neuron(&LifParameters::delta_g, 0.8), 1,
         Uncertainty{.adaptation = 0.2}},
        {"hysteresis", "hysteresis, 8 %", grips, hysteresis_untold, 1, Uncertainty{.hysteresis = 0.08}},
        {"tenth", "nothing, all forces a tenth; errors times 10", grips, forces_times(0.1), 1, {}, true},
        {"hundredth", "nothing, all forces a hundredth; errors times 100", grips, forces_times(0.01)},
        {"ten_times", "nothing, all forces ten times; errors a tenth", grips, forces_times(10)},
        {"lost", "10 % of packets lost", grips, lost_packets, 5},
        {"sine", "sine of 5 Hz, 10 N by half", sine, nothing, 1, {}, true},
        {"tremor", "tremor of 10 Hz, 1.5 N", grips, tremor},
        {"release", "release faster than 10 N/s", grips, fast_release},
        {"one_neuron", "nothing, one neuron a force", columns_by_themselves, nothing},
    };
    return cases;
}

}  // namespace afferent
