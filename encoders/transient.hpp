// The transient kind: a drive in proportion to the rectified rate of change, as rapidly adapting afferents
// respond to both onset and release.
#pragma once

#include <cmath>
#include <limits>
#include <utility>

#include "afferent/encoders/encoder.hpp"

namespace afferent {

//     drive = gain · |d force / dt| + bias
//
// The rate of change is the slope from the sample before, and 0 at the first sample.
class Transient {
  public:
    struct Parameters {
        double gain_mv_s_per_n;
        double bias_mv = 0;

        // Throws ParameterError: gain_mv_s_per_n > 0, both finite.
        void check() const;

        // What every encoder in the list of encoders/encoders.hpp tells of itself.
        static constexpr const char* name = "transient";
        static constexpr const char* gain_name = "gain_mv_s_per_n";
        static constexpr EncoderInput input = EncoderInput::slope;
        static constexpr bool decodable = true;
        double gain_of_input() const noexcept { return gain_mv_s_per_n; }
        static Seconds settling() noexcept { return Seconds(0); }
        static Parameters with(double gain, double bias_mv) noexcept { return {gain, bias_mv}; }
        // A force changes by no more than its range from one sample to the next.
        static double largest_input(double range_n, std::optional<Interval> sampling) noexcept {
            return sampling ? range_n / Seconds(*sampling).count() : std::numeric_limits<double>::infinity();
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
        return gain_ * std::abs(force_n - before.force_n) / seconds(time - before.time) + bias_;
    }

  private:
    double gain_;
    double bias_;
};

static_assert(Encoder<Transient>);

}  // namespace afferent
