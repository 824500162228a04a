// Random numbers that are a function of what they are for, so that they do not depend on the order of asking.
#pragma once

#include <cstdint>

namespace afferent {

// What a stream of numbers is for; with the address it keeps streams of one seed apart.
enum class Stream : std::uint32_t {
    sensor_noise,
    closing_emg,
    opening_emg,
    // Where an afferent lies, and how it differs from the others of its patch.
    afferent_place,
    afferent_field,
    afferent_gain,
    afferent_threshold,
    afferent_delta_g,
    afferent_phase,
    afferent_time_class,
    texture_phase,
    // What differs from one presentation of a trial to the next.
    trial_kind,
    trial_stiffness,
    trial_distance,
    trial_breaking,
    trial_weight,
    trial_user,
    trial_aim,
    trial_reach,
    trial_reaction,
    trial_radio,
    trial_gain,
    trial_common_gain,
    trial_share,
    trial_dead,
    // Of an emulated hand: what its untouched sensors read, and what a noisy line does to its frames.
    untouched_reading,
    line_noise,
    // Of an emulated channel: the faults of what comes back, and in which presentation of a trial.
    way_back,
    afferent_noise,
};

// Standard normal: the index-th number of the stream of this address under this seed (Philox 4x32-10, Salmon
// et al., SC 2011; Box–Muller).
double gaussian(std::uint64_t seed, Stream stream, std::uint32_t address, std::uint64_t index) noexcept;

// The same, uniform in [0, 1).
double uniform(std::uint64_t seed, Stream stream, std::uint32_t address, std::uint64_t index) noexcept;

// A seed for the numbers of something else.
std::uint64_t random_seed(std::uint64_t seed, Stream stream, std::uint32_t address) noexcept;

}  // namespace afferent
