// The parameters of the decoders that a scene can choose. To be included by programs that make a decoder
// without a scene (grip_decoder.hpp).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <variant>

#include "afferent/decoders/force_motion.hpp"
#include "afferent/decoders/pooling.hpp"
#include "afferent/neurons/rate_kind.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

struct SlidingWindowParameters {
    Duration window = 60ms;
    RateKind curve = RateKind::steady;
    Pooling pooling = Pooling::pooled;
    friend bool operator==(const SlidingWindowParameters&, const SlidingWindowParameters&) = default;
};

struct ExponentialParameters {
    Duration time_constant = 40ms;
    RateKind curve = RateKind::steady;
    Pooling pooling = Pooling::pooled;
    friend bool operator==(const ExponentialParameters&, const ExponentialParameters&) = default;
};

struct InverseIntervalParameters {
    RateKind curve = RateKind::steady;
    Pooling pooling = Pooling::pooled;
    friend bool operator==(const InverseIntervalParameters&, const InverseIntervalParameters&) = default;
};

struct InversionParameters {
    friend bool operator==(const InversionParameters&, const InversionParameters&) = default;
};

// How the filter expects a force to move, in units of the afferents' range: of 20 N, where they fire at
// 100 Hz.
struct ForceBeliefParameters {
    enum Motions { hold, movement, contact, release, adjustment, tremor, motions };
    std::array<ForceMotion, motions> motion = {{{0.042, 0.073, 4e-5, 5.6},
                                                {62, 0.16, 5e-7, 0.98},
                                                {70, 0.021, 2.6e-6, 47},
                                                {1.5, 0.043, 4e-6, 0.48},
                                                {2.2, 6.8, 1.7e-5, 1.2},
                                                {45, 0.0066, 1e-6, 0.82}}};
    double releases = 3.7;
    double slow_n_per_s = 10;  // a force that falls no faster than this is not being released
    double leaves_rest_per_s = 0.15;

    ForceFlow flow(std::size_t of, double dt_s) const noexcept {
        return of == release ? returning(motion[of], dt_s) : wandering(motion[of], dt_s);
    }
    // At which any motion but a release becomes one.
    double releases_per_s(double force_n, double speed_n_per_s) const noexcept {
        return releases * std::max(0.0, -speed_n_per_s - slow_n_per_s) / std::max(force_n, 0.3);
    }
    friend bool operator==(const ForceBeliefParameters&, const ForceBeliefParameters&) = default;
};

// In newtons, where they are stated.
struct FilterMotion {
    std::optional<double> speed_n_per_s{};
    std::optional<double> drift_n2_per_s{};
    friend bool operator==(const FilterMotion&, const FilterMotion&) = default;
};

struct FilterParameters {
    ForceBeliefParameters force{};  // in units of the afferents' range: of 20 N, where they fire at 100 Hz
    std::array<FilterMotion, ForceBeliefParameters::motions> motion{};
    friend bool operator==(const FilterParameters&, const FilterParameters&) = default;
};

using DecoderParameters = std::variant<SlidingWindowParameters, ExponentialParameters,
                                       InverseIntervalParameters, InversionParameters, FilterParameters>;

}  // namespace afferent
