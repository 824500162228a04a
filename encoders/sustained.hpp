// The sustained kind: a drive in proportion to force, and to its rise where that is asked for, as slowly
// adapting afferents respond.
#pragma once

#include <algorithm>
#include <cmath>
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

// A sustained encoder of what slow adaptation leaves of the force F:
//
//     F' = max(0, F − part · y),      dy/dt = (F − y)/time
//
// so that a held force drives by 1 − part of what it did at its beginning. F is the straight line between two
// samples, for which y is solved exactly; what has been released is forgotten at the same pace, sampled or
// not.
template <class Inner>
class SlowlyAdapting {
  public:
    struct Parameters : Inner::Parameters {
        double part;
        Seconds slow_time;

        // Throws ParameterError: as the encoder's own; 0 < part < 1, slow_time > 0 and finite.
        void check() const;

        static constexpr bool decodable() noexcept { return false; }
        Parameters with(double gain, double new_bias_mv) const noexcept {
            return {Inner::Parameters::with(gain, new_bias_mv), part, slow_time};
        }
    };
    struct State {
        typename Inner::State inner;
        TimePoint time = TimePoint::min();
        double force_n = 0;
        double behind_n = 0;  // y − F
    };

    // Throws ParameterError as Parameters::check() does.
    explicit SlowlyAdapting(const Parameters& parameters);

    double drive_mv(State& state, TimePoint time, double force_n) const noexcept {
        // Before the first sample the force was 0, and nothing adapted to it.
        const double change_n = force_n - state.force_n;
        if (state.time == TimePoint::min()) {
            state.behind_n = -force_n;
        } else {
            const double s = per_s_ * seconds(time - state.time);
            state.behind_n = state.behind_n * std::exp(-s) + change_n * std::expm1(-s) / s;
        }
        state.time = time;
        state.force_n = force_n;
        return inner_.drive_mv(state.inner, time,
                               std::max(0.0, force_n - part_ * (force_n + state.behind_n)));
    }

  private:
    Inner inner_;
    double part_;
    double per_s_;
};

static_assert(Encoder<Sustained>);
static_assert(Encoder<DynamicSustained>);
static_assert(Encoder<SlowlyAdapting<Sustained>>);
static_assert(Encoder<SlowlyAdapting<DynamicSustained>>);

}  // namespace afferent
