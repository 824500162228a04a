// A user who closes, holds and opens, as seen by two electrodes. Included by whoever builds a scene with a
// simulated user, or passes EMG to a controller.
#pragma once

#include <cstdint>

#include "afferent/runtime/time.hpp"

namespace afferent {

// One sample of the EMG, in counts of a 12-bit converter.
struct Emg {
    double closing_counts;
    double opening_counts;
};

// Surface EMG as Gaussian noise around rest, with a mean absolute value of effort times full scale (Hogan and
// Mann, IEEE Trans. Biomed. Eng. 1980).
class User {
  public:
    struct Parameters {
        double close_at_s = 1;
        double close_for_s = 4;
        double hold_for_s = 2.5;
        double open_for_s = 1.5;
        double effort = 0.5;
        double ramp_s = 0.3;
        double hold_effort = 0.05;
        bool operator==(const Parameters&) const = default;
    };
    static constexpr double rest_counts = 2048;
    static constexpr double full_scale_counts = 500;

    // Throws ParameterError unless times are >= 0, ramp_s > 0, and effort and hold_effort are in [0, 1].
    User(const Parameters& parameters, std::uint64_t seed);

    // Effort of the closing and the opening muscle, 0 to 1.
    double closing_effort(TimePoint time) const noexcept;
    double opening_effort(TimePoint time) const noexcept;

    // The index-th sample, taken at that time.
    Emg emg(TimePoint time, std::uint64_t index) const noexcept;

  private:
    Parameters parameters_;
    std::uint64_t seed_;
};

}  // namespace afferent
