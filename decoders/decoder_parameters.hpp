// The parameters of the decoders that a scene can choose. Included by programs that construct a decoder
// without a scene (grip_decoder.hpp).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <variant>

#include "afferent/neurons/parameters.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// How decoders by rates combine the afferents.
enum class Pooling {
    pooled,      // one curve from the grip force to the sum of all rates
    per_neuron,  // each neuron's rate through its own curve; then their mean
};

// The parameters of every decoder of rates say two things of it to gain_reach.hpp:
//
//   trough_hz(rate_hz)   the lowest rate that it finds in a regular train, just before the next spike
//   window_s()           the length of a sliding window whose rate is as uncertain (grip_estimator.hpp)

struct SlidingWindowParameters {
    Duration window = 60ms;
    RateKind curve = RateKind::steady;
    Pooling pooling = Pooling::pooled;
    // The window holds at least so many whole spikes. What rounds to a whole number counts.
    double trough_hz(double rate_hz) const noexcept {
        return std::floor(rate_hz * window_s() * (1 + 1e-9)) / window_s();
    }
    double window_s() const noexcept { return seconds(window); }
    friend bool operator==(const SlidingWindowParameters&, const SlidingWindowParameters&) = default;
};

struct ExponentialParameters {
    Duration time_constant = 40ms;
    RateKind curve = RateKind::steady;
    Pooling pooling = Pooling::pooled;
    // For the interval P it is Σ e^(−kP/tau)/tau over k = 1, 2, ...  =  1/(tau (e^(P/tau) − 1)).
    double trough_hz(double rate_hz) const noexcept {
        const double tau_s = seconds(time_constant);
        return rate_hz > 0 ? 1 / (tau_s * std::expm1(1 / (rate_hz * tau_s))) : 0;
    }
    double window_s() const noexcept { return std::sqrt(2) * seconds(time_constant); }
    friend bool operator==(const ExponentialParameters&, const ExponentialParameters&) = default;
};

struct InverseIntervalParameters {
    RateKind curve = RateKind::steady;
    Pooling pooling = Pooling::pooled;
    // The reciprocal of the time since the last spike does not fall below the rate before the next.
    double trough_hz(double rate_hz) const noexcept { return rate_hz; }
    // Nothing changes from one interval to the next.
    double window_s() const noexcept { return 1e6; }
    friend bool operator==(const InverseIntervalParameters&, const InverseIntervalParameters&) = default;
};

struct InversionParameters {
    friend bool operator==(const InversionParameters&, const InversionParameters&) = default;
};

// One mode of motion of the force: its rate of change has the standard deviation `speed` and the correlation
// time `time`, and the force itself diffuses in addition.
struct ForceMotion {
    double speed_n_per_s;   // σ
    double time_s;          // τ
    double drift_n2_per_s;  // q²
    double leaves_per_s;    // rate of transitions into other motions
    friend bool operator==(const ForceMotion&, const ForceMotion&) = default;
};

// The filter's model of how a force moves. Forces are scaled to the afferents' range: the numbers hold for a
// range of 20 N, in which the afferents fire at up to 100 Hz.
struct ForceBeliefParameters {
    enum Motions { hold, movement, contact, release, adjustment, tremor, motions };
    std::array<ForceMotion, motions> motion = {{{0.042, 0.073, 4e-5, 5.6},
                                                {62, 0.16, 5e-7, 0.98},
                                                {70, 0.021, 2.6e-6, 47},
                                                {1.5, 0.043, 4e-6, 0.48},
                                                {2.2, 6.8, 1.7e-5, 1.2},
                                                {45, 0.0066, 1e-6, 0.82}}};
    double releases = 3.7;
    double slow_n_per_s = 10;  // a force that falls more slowly is not being released
    double leaves_rest_per_s = 0.15;

    // The rate of transitions from any other motion to a release.
    double releases_per_s(double force_n, double speed_n_per_s) const noexcept {
        return releases * std::max(0.0, -speed_n_per_s - slow_n_per_s) / std::max(force_n, 0.3);
    }
    friend bool operator==(const ForceBeliefParameters&, const ForceBeliefParameters&) = default;
};

// Overrides of a motion's parameters, in newtons; absent values are the filter's own.
struct FilterMotion {
    std::optional<double> speed_n_per_s{};
    std::optional<double> drift_n2_per_s{};
    friend bool operator==(const FilterMotion&, const FilterMotion&) = default;
};

struct FilterParameters {
    ForceBeliefParameters force{};  // scaled to the afferents' range
    std::array<FilterMotion, ForceBeliefParameters::motions> motion{};
    // How far ahead Estimate::coming looks; 0: it is not estimated.
    Duration lead{};
    friend bool operator==(const FilterParameters&, const FilterParameters&) = default;
};

using DecoderParameters = std::variant<SlidingWindowParameters, ExponentialParameters,
                                       InverseIntervalParameters, InversionParameters, FilterParameters>;

}  // namespace afferent
