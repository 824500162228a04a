// The transient kind: a drive in proportion to the rectified rate of change, as rapidly adapting afferents
// respond to onset and, unless the negative half-wave is left out, to release.
#pragma once

#include <cmath>
#include <limits>
#include <utility>

#include "afferent/encoders/encoder.hpp"

namespace afferent {

//     drive = gain · rectified(d force / dt) + bias
//
// The rate of change is the slope from the sample before, and 0 at the first sample.
class Transient {
  public:
    struct Parameters {
        double gain_mv_s_per_n;
        double bias_mv = 0;
        Rectification rectification = {};

        // Throws ParameterError: gain_mv_s_per_n > 0, both finite, and as Rectification.
        void check() const;

        // What every encoder in the list of encoders/encoders.hpp tells of itself.
        static constexpr const char* name = "transient";
        static constexpr const char* gain_name = "gain_mv_s_per_n";
        static constexpr EncoderInput input = EncoderInput::slope;
        static constexpr const char* threshold_name = "threshold_n_per_s";
        // A decoder inverts the size of the rate, which half of a wave and a threshold do not tell.
        bool decodable() const noexcept { return rectification == Rectification(); }
        double gain_of_input() const noexcept { return gain_mv_s_per_n; }
        static Seconds settling() noexcept { return Seconds(0); }
        Parameters with(double gain, double new_bias_mv) const noexcept {
            return {gain, new_bias_mv, rectification};
        }
        // A force changes by no more than its range from one sample to the next.
        double largest_input(double range_n, std::optional<Interval> sampling) const noexcept {
            if (!sampling) return std::numeric_limits<double>::infinity();
            return rectification.largest(range_n / Seconds(*sampling).count());
        }
    };
    struct State {
        TimePoint time = TimePoint::min();
        double force_n = 0;
    };

    // Throws ParameterError.
    explicit Transient(const Parameters& parameters);

    double drive_mv(State& state, TimePoint time, double force_n) const noexcept {
        const State before = std::exchange(state, {time, force_n});
        if (before.time == TimePoint::min()) return bias_;
        const double span_s = seconds(time - before.time);
        return gain_ * rectified_(force_n - before.force_n, span_s) / span_s + bias_;
    }

  private:
    double gain_;
    double bias_;
    Rectification rectified_;
};

static_assert(Encoder<Transient>);

}  // namespace afferent
