// The transient channel: drive in proportion to the rectified rate of change, as rapidly adapting afferents
// respond to both onset and release.
#pragma once

#include <cmath>
#include <utility>

#include "afferent/encoders/encoder.hpp"

namespace afferent {

//     drive = gain · |d force / dt| + bias        d force / dt: the slope from the sample before; 0 at the
//     first
class Transient {
  public:
    struct Parameters {
        double gain_mv_s_per_n;
        double bias_mv = 0;
    };
    struct State {
        TimePoint time = TimePoint::min();
        double force_n = 0;
    };

    // Throws ParameterError: gain_mv_s_per_n > 0, both finite.
    explicit Transient(const Parameters& parameters);

    double drive_mv(State& state, TimePoint time, double force_n) const noexcept {
        const State before = std::exchange(state, {time, force_n});
        if (before.time == TimePoint::min()) return bias_;
        return gain_ * std::abs(force_n - before.force_n) / seconds(time - before.time) + bias_;
    }

  private:
    double gain_;
    double bias_;
};

static_assert(Encoder<Transient>);

}  // namespace afferent
