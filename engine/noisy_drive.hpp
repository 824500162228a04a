// The noise of an afferent, as it adds to the drive of its neuron.
#pragma once

#include <algorithm>

#include "afferent/hand/random.hpp"
#include "afferent/scene/patch_plan.hpp"

namespace afferent {

// A function of the address and the time, and so the same for any threads, shards and ranks. What nothing
// drives is silent: at its drive at rest, an afferent has no noise.
class NoisyDrive {
  public:
    explicit NoisyDrive(const DriveNoise& noise) : noise_(noise) {}

    bool is_none() const noexcept { return noise_.sd_mv == 0; }
    void set_rest(double drive_mv) noexcept { rest_mv_ = drive_mv; }
    double operator()(double drive_mv, Address address, TimePoint time) const noexcept {
        if (drive_mv == rest_mv_) return drive_mv;
        const double deviations = gaussian(noise_.seed, Stream::afferent_noise, address,
                                           static_cast<std::uint64_t>((time - scene_start).count()));
        return drive_mv + noise_.sd_mv * std::clamp(deviations, -DriveNoise::most_deviations,
                                                    DriveNoise::most_deviations);
    }

  private:
    DriveNoise noise_;
    double rest_mv_ = 0;
};

}  // namespace afferent
