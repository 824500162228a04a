#include "bench/error_scene.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "afferent/neurons/tuning.hpp"

namespace afferent::bench {
namespace {

// Closing, holding with a tremor of 8 Hz, opening; in N, over a time from 0 to 1.
double grasp_n(double part, double seconds) {
    const auto smooth = [](double x) { return x <= 0 ? 0 : x >= 1 ? 1 : x * x * (3 - 2 * x); };
    const double hold = smooth((part - 0.1) / 0.25) * (1 - smooth((part - 0.75) / 0.15));
    return hold * (10 + 0.4 * std::sin(2 * std::numbers::pi * 8 * seconds));
}

struct Shape {
    std::string name;
    std::vector<LifParameters> parameters;
    std::size_t neurons;
    Duration scan_interval;
    double seconds;
    std::size_t judged;
    double noise_n = 0;
    // The share of each neuron differs a little.
    double gain_mv_per_n;
    double bias_mv;
};

ErrorScene make(const Shape& shape) {
    ErrorScene scene;
    Workload& workload = scene.workload;
    workload.name = shape.name;
    workload.parameters = shape.parameters;
    workload.neurons = shape.neurons;
    const auto rows = static_cast<std::size_t>(shape.seconds / Seconds(shape.scan_interval).count());
    workload.until = scene_start + static_cast<Duration::rep>(rows) * shape.scan_interval;

    std::mt19937_64 random(7);
    std::normal_distribution<> normal;
    for (std::size_t i = 0; i < shape.neurons; ++i) {
        const double share = shape.neurons == 1 ? 1
                                                : 0.8 + 0.4 * static_cast<double>(i * 7 % shape.neurons) /
                                                            static_cast<double>(shape.neurons - 1);
        scene.gain_mv_per_n.push_back(shape.gain_mv_per_n * share);
        // The threshold of a neuron moves the force at which it begins to fire; its bias compensates for
        // that.
        scene.bias_mv.push_back(shape.bias_mv + workload.of(i).rheobase_mv() -
                                shape.parameters.front().rheobase_mv());
    }
    // A 12-bit converter with a full scale of 20 N.
    constexpr double count_n = 20.0 / 4096;
    for (std::size_t row = 0; row < rows; ++row) {
        const TimePoint time = scene_start + static_cast<Duration::rep>(row) * shape.scan_interval;
        workload.times.push_back(time);
        const double force_n = grasp_n(static_cast<double>(row) / static_cast<double>(rows), seconds(time));
        scene.force_n.push_back(force_n);
        for (std::size_t i = 0; i < shape.neurons; ++i) {
            const double noisy_n = std::max(0.0, force_n + shape.noise_n * normal(random));
            const double sample_n = std::round(noisy_n / count_n) * count_n;
            workload.drives_mv.push_back(scene.gain_mv_per_n[i] * sample_n + scene.bias_mv[i]);
        }
    }
    for (std::size_t k = 0; k < shape.judged; ++k) scene.judged.push_back(k * shape.neurons / shape.judged);
    return scene;
}

}  // namespace

std::vector<ErrorScene> error_scenes(bool quick) {
    const LifParameters paper;
    const Tuned tuned =
        tune(paper, {.rate = RateKind::steady, .rate_hz = 100, .input = 20, .begin_input = 0.3});
    LifParameters stiff;
    stiff.tau_g_ms = 0.01;
    stiff.delta_g = 30;
    LifParameters slow;
    slow.tau_g_ms = 100'000;
    slow.delta_g = 30;

    constexpr std::size_t population = 1000;
    std::vector<LifParameters> mixed(population);
    std::mt19937_64 random(3);
    std::uniform_real_distribution<> unit;
    for (LifParameters& each : mixed) {
        each.v_th_mv = -53 + 6 * unit(random);
        each.delta_g = 0.02 + 0.3 * unit(random);
    }
    mixed.front() = paper;

    const double time_s = quick ? 1 : 6;
    const std::size_t judged = quick ? 4 : 20;
    // The crowd shows the cost of a neuron among many: each has its own drive, and fires at 30 Hz on average.
    return {
        make({"grasp", {paper}, 9, 5ms, time_s, quick ? 3UL : 9UL, 0, tuned.gain, tuned.bias_mv}),
        make({"noise", {paper}, 64, 1ms, quick ? 0.5 : 3, judged, 3, 2 * tuned.gain, tuned.bias_mv}),
        // Truth takes long for each spike of these.
        make(
            {"stiff", {stiff}, 64, 5ms, quick ? 0.5 : 2, quick ? 2UL : 6UL, 0, 5, paper.rheobase_mv() - 1.5}),
        // A lasting conductance of 30 and more needs a drive of some hundreds of mV.
        make({"slow", {slow}, 64, 5ms, quick ? 0.5 : time_s, judged, 0, 300, paper.rheobase_mv() - 90}),
        make({"population", mixed, population, 5ms, quick ? 0.5 : 3, judged, 0.2, 2 * tuned.gain,
              tuned.bias_mv}),
        make({"crowd", {paper}, 10'000, 5ms, quick ? 0.05 : 1, judged, 2, 0.85 * tuned.gain, tuned.bias_mv}),
    };
}

}  // namespace afferent::bench
