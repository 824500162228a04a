#include "bench/truth.hpp"

#include <stdexcept>

#include "afferent/neurons/adapting_lif.hpp"
#include "bench/reference.hpp"

namespace afferent::bench {
namespace {

using reference::Real;

constexpr std::int64_t ns_per_s = 1'000'000'000;

SpikeTime spike_time(TimePoint since, const Real& after_s) {
    const Real ns = after_s * ns_per_s;
    const auto whole = static_cast<std::int64_t>(floor(ns));
    return {since + Duration(whole), Interval(static_cast<double>(ns - whole))};
}

// Our own model gives a good first guess, which the reference confirms or corrects.
AdaptingLif guesser(LifParameters parameters) {
    parameters.refractory_ms = 0;
    return AdaptingLif(parameters);
}

}  // namespace

Train true_train(const Workload& workload, std::size_t neuron) {
    const LifParameters& parameters = workload.of(neuron);
    const reference::Neuron truth(parameters);
    const AdaptingLif guess = guesser(parameters);
    Train train;
    reference::State state = truth.rest();
    Real blocked_s = 0;
    for (std::size_t row = 0; row < workload.rows() && train.size() < workload.max_spikes; ++row) {
        const double drive_mv = workload.drive_mv(row, neuron);
        const Real length_s = Real((workload.end(row) - workload.times[row]).count()) / ns_per_s;
        Real passed_s = 0;
        while (passed_s < length_s && train.size() < workload.max_spikes) {
            const Real left_s = length_s - passed_s;
            if (blocked_s > 0) {
                const Real held_s = blocked_s < left_s ? blocked_s : left_s;
                truth.hold(state, held_s);
                blocked_s -= held_s;
                passed_s += held_s;
                continue;
            }
            const reference::State end = truth.advance(state, drive_mv, left_s);
            if (end.gap_mv > 0) {
                state = end;
                break;
            }
            const AdaptingLif::State rough{static_cast<double>(state.gap_mv), static_cast<double>(state.g)};
            const Interval near = guess.next_spike(rough, drive_mv);
            const Real span_s = *truth.next_spike_s(state, drive_mv, Seconds(near).count());
            truth.hold(state, span_s);
            truth.fire(state);
            passed_s += span_s;
            blocked_s = truth.refractory_s();
            train.push_back(spike_time(workload.times[row], passed_s));
        }
    }
    return train;
}

SettledTrain::SettledTrain(const LifParameters& parameters, double drive_mv) {
    const reference::Neuron truth(parameters);
    const AdaptingLif guess = guesser(parameters);
    reference::State state = truth.rest();
    Real now_s = 0;
    Real interval_s = 0;
    for (int spikes = 0; spikes < 5000; ++spikes) {
        const AdaptingLif::State rough{static_cast<double>(state.gap_mv), static_cast<double>(state.g)};
        const Interval near = guess.next_spike(rough, drive_mv);
        const auto span_s = truth.next_spike_s(state, drive_mv, Seconds(near).count());
        if (!span_s) break;
        truth.hold(state, *span_s);
        truth.fire(state);
        now_s += *span_s;
        beginning_.push_back(spike_time(scene_start, now_s));
        const Real next_s = *span_s + truth.refractory_s();
        if (abs(next_s - interval_s) < next_s * 1e-25) {
            const Real ns = next_s * ns_per_s;
            interval_ns_ = static_cast<std::int64_t>(floor(ns));
            interval_rest_ns_ = static_cast<long double>(ns - interval_ns_);
            return;
        }
        interval_s = next_s;
        now_s += truth.refractory_s();
        truth.hold(state, truth.refractory_s());
    }
    throw std::runtime_error("the neuron does not settle under this drive");
}

SpikeTime SettledTrain::spike(std::size_t n) const {
    if (n < beginning_.size()) return beginning_[n];
    const std::size_t more = n - (beginning_.size() - 1);
    const long double rest = interval_rest_ns_ * static_cast<long double>(more);
    const auto whole = static_cast<std::int64_t>(rest);
    const SpikeTime& last = beginning_.back();
    return {last.near + Duration(interval_ns_ * static_cast<std::int64_t>(more) + whole),
            last.rest + Interval(static_cast<double>(rest - static_cast<long double>(whole)))};
}

}  // namespace afferent::bench
