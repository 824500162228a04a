// Drives by the rectified rate of change of a low-passed force, or by the change of that rate: what Meissner
// and Pacinian afferents, which have a best frequency, respond to.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "afferent/encoders/encoder.hpp"

namespace afferent {

//     drive = gain · rectified(dⁿx / dtⁿ) + bias        n = order, 1 or 2
//
// x is the force F after 2n equal lags in a row, each  dx_k/dt = w (x_(k−1) − x_k)  with x_0 = F and
// w = 2π corner_hz. So under a force A sin(2πft) the derivative has the amplitude
//
//     A (2πf)ⁿ / (1 + (f/corner)²)ⁿ
//
// which is largest, A (w/2)ⁿ, at the corner.
//
// The force is the straight line between two samples, however far they are apart, and the lags are solved
// exactly for it: in units of 1/w they follow a ramp of slope m by F − m k, and the deviation e_k from that
// decays as
//
//     e_k(s) = e^(−s) Σ_j e_(k−j)(0) s^j / j!
//
// The state is x_k − F, which is 0 under a held force. Like a slope, the drive is known at the sample that
// ends the line. At the first sample the force is taken to have been held.
template <int order>
class BandLimited {
    static_assert(order == 1 || order == 2);
    static constexpr std::size_t lags = 2 * std::size_t{order};

  public:
    struct Parameters {
        double gain;  // in mV s/N or mV s²/N
        double bias_mv;
        double corner_hz;
        Rectification rectification = {};

        // Throws ParameterError: gain > 0, corner_hz > 0, all finite, and as Rectification.
        void check() const;

        // What every encoder in the list of encoders/encoders.hpp tells of itself.
        static constexpr const char* name = order == 1 ? "transient" : "vibration";
        static constexpr const char* gain_name = order == 1 ? "gain_mv_s_per_n" : "gain_mv_s2_per_n";
        static constexpr EncoderInput input = order == 1 ? EncoderInput::slope : EncoderInput::change;
        static constexpr const char* threshold_name = order == 1 ? "threshold_n_per_s" : "threshold_n_per_s2";
        static constexpr bool decodable() noexcept { return false; }
        double gain_of_input() const noexcept { return gain; }
        Parameters with(double new_gain, double new_bias_mv) const noexcept {
            return {new_gain, new_bias_mv, corner_hz, rectification};
        }
        // s³ e^(−s) is below 1e-9 from s = 31 on.
        Seconds settling() const noexcept { return Seconds(31 / (2 * std::numbers::pi * corner_hz)); }
        double largest_input(double range_n, std::optional<Interval>) const noexcept;
    };
    struct State {
        TimePoint time = TimePoint::min();
        double force_n = 0;
        std::array<double, lags> behind_n{};  // x_1 − F, x_2 − F, ...
    };

    // Throws ParameterError.
    explicit BandLimited(const Parameters& parameters);

    double drive_mv(State& state, TimePoint time, double force_n) const noexcept {
        if (state.time != TimePoint::min())
            follow(state, force_n - state.force_n, corner_per_s_ * seconds(time - state.time));
        state.time = time;
        state.force_n = force_n;
        return gain_ * rectified_(derivative(state.behind_n)) + bias_;
    }

  private:
    // The force changes by that much, along a line of s units of time.
    static void follow(State& state, double change_n, double s) noexcept {
        const double slope = change_n / s;
        const double kept = std::exp(-s);
        std::array<double, lags> e;
        for (std::size_t k = 0; k < lags; ++k) e[k] = state.behind_n[k] + slope * static_cast<double>(k + 1);
        for (std::size_t k = 0; k < lags; ++k) {
            // By Horner's rule: e_k + s (e_(k−1) + s/2 (e_(k−2) + ...)).
            double sum = e[0];
            for (std::size_t j = k; j > 0; --j) sum = e[k - j + 1] + sum * s / static_cast<double>(j);
            state.behind_n[k] = (kept > 0 ? kept * sum : 0) - slope * static_cast<double>(k + 1);
        }
    }

    // dⁿx/dtⁿ, which the lags' equations give as a difference.
    double derivative(const std::array<double, lags>& x) const noexcept {
        if constexpr (order == 1) return corner_per_s_ * (x[0] - x[1]);
        if constexpr (order == 2) return corner_per_s_ * corner_per_s_ * ((x[1] - x[2]) - (x[2] - x[3]));
    }

    double gain_;
    double bias_;
    double corner_per_s_;  // w
    Rectification rectified_;
};

using BandTransient = BandLimited<1>;
using Vibration = BandLimited<2>;

static_assert(Encoder<BandTransient>);
static_assert(Encoder<Vibration>);

}  // namespace afferent
