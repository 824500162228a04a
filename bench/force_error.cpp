#include "bench/force_error.hpp"

#include <cmath>
#include <unordered_map>

#include "afferent/neurons/rate.hpp"

namespace afferent::bench {

std::optional<double> force_rms_n(const ErrorScene& scene, const Trains& trains) {
    if (scene.force_n.empty()) return std::nullopt;
    constexpr Duration window = 60ms;
    const Workload& workload = scene.workload;
    std::vector<double> estimate_n(workload.rows(), 0);
    for (const std::size_t neuron : scene.judged) {
        const Train& train = trains[neuron];
        // A window holds a whole number of spikes, so there are few rates to invert.
        std::unordered_map<std::size_t, double> force_n{{0, 0.0}};
        std::size_t in = 0;
        std::size_t out = 0;
        for (std::size_t row = 0; row < workload.rows(); ++row) {
            const SpikeTime now{workload.times[row], Interval(0)};
            while (in < train.size() && (train[in] - now).count() <= 0) ++in;
            while (out < in && (train[out] - now) <= Interval(-window)) ++out;
            const auto [at, fresh] = force_n.try_emplace(in - out);
            if (fresh) {
                const double rate = static_cast<double>(in - out) / Seconds(window).count();
                const double drive = drive_mv(RateKind::steady, workload.of(neuron), rate);
                at->second = (drive - scene.bias_mv[neuron]) / scene.gain_mv_per_n[neuron];
            }
            estimate_n[row] += at->second / static_cast<double>(scene.judged.size());
        }
    }
    double sum = 0;
    for (std::size_t row = 0; row < workload.rows(); ++row) {
        const double error_n = estimate_n[row] - scene.force_n[row];
        sum += error_n * error_n;
    }
    return std::sqrt(sum / static_cast<double>(workload.rows()));
}

}  // namespace afferent::bench
