// The sustained kind: a drive in proportion to force, and to its rise where that is asked for, as slowly
// adapting afferents respond.
#pragma once

#include <optional>

#include "afferent/encoders/band_limited.hpp"
#include "afferent/encoders/encoder.hpp"

namespace afferent {

//     drive = gain · force + bias
class Sustained {
  public:
    struct Parameters {
        double gain_mv_per_n;
        double bias_mv = 0;

        // Throws ParameterError: gain_mv_per_n > 0, both finite.
        void check() const;

        // What every encoder in the list of encoders/encoders.hpp tells of itself.
        static constexpr const char* name = "sustained";
        static constexpr const char* gain_name = "gain_mv_per_n";
        static constexpr EncoderInput input = EncoderInput::force;
        static constexpr bool decodable() noexcept { return true; }
        double gain_of_input() const noexcept { return gain_mv_per_n; }
        static Seconds settling() noexcept { return Seconds(0); }
        static Parameters with(double gain, double bias_mv) noexcept { return {gain, bias_mv}; }
        static double largest_input(double range_n, std::optional<Interval>) noexcept { return range_n; }
    };
    struct State {};

    // Throws ParameterError.
    explicit Sustained(const Parameters& parameters);

    double drive_mv(State&, TimePoint, double force_n) const noexcept { return gain_ * force_n + bias_; }

  private:
    double gain_;
    double bias_;
};

//     drive = gain · (F + time · max(0, dx/dt)) + bias
//
// where x is the force F behind two lags, as for BandTransient: a force that rises drives more than one that
// is held, as Merkel afferents respond.
class DynamicSustained {
  public:
    struct Parameters {
        double gain_mv_per_n;
        double bias_mv;
        Seconds time;
        double corner_hz;

        // Throws ParameterError: gain_mv_per_n > 0, time_ms > 0, corner_hz > 0, all finite.
        void check() const;

        static constexpr const char* name = "sustained";
        static constexpr const char* gain_name = "gain_mv_per_n";
        static constexpr EncoderInput input = EncoderInput::force;
        static constexpr bool decodable() noexcept { return false; }
        double gain_of_input() const noexcept { return gain_mv_per_n; }
        Parameters with(double gain, double new_bias_mv) const noexcept {
            return {gain, new_bias_mv, time, corner_hz};
        }
        Seconds settling() const noexcept { return rise().settling(); }
        double largest_input(double range_n, std::optional<Interval> sampling) const noexcept {
            return range_n + rise().largest_input(range_n, sampling) * time.count();
        }
        BandTransient::Parameters rise() const noexcept {
            return {time.count(), 0, corner_hz, {.negative_ratio = 0}};
        }
    };
    using State = BandTransient::State;

    // Throws ParameterError as Parameters::check() does.
    explicit DynamicSustained(const Parameters& parameters);

    double drive_mv(State& state, TimePoint time, double force_n) const noexcept {
        return gain_ * (force_n + rise_.drive_mv(state, time, force_n)) + bias_;
    }

  private:
    double gain_;
    double bias_;
    BandTransient rise_;  // in N
};

static_assert(Encoder<Sustained>);
static_assert(Encoder<DynamicSustained>);

}  // namespace afferent
