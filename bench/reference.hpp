// The adapting neuron to 50 digits, by a method of its own: what the tests and benchmarks call truth.
#pragma once

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <limits>
#include <optional>

#include "afferent/neurons/parameters.hpp"

namespace afferent::reference {

// With fifty digits rounding does not matter; series are cut off below 1e-30.
using Real =
    boost::multiprecision::number<boost::multiprecision::cpp_bin_float<50>, boost::multiprecision::et_off>;

struct State {
    Real gap_mv;  // v_th − v
    Real g;
};

// With time in units of tau_m and x = a g as the independent variable, the membrane equation is
//     x dz/dx = (a + x) z − x W + a c,
// whose Taylor coefficients around any x > 0 follow from each other by a recurrence of two terms. The
// interval is cut so that x falls by at most three tenths in a step and the exponent grows by at most 5; the
// past is dropped where only e^−80 of it remains, and so is a conductance below 1e-30 of what drives the
// membrane.
class Neuron {
  public:
    explicit Neuron(const LifParameters& parameters)
        : tau_m_s_(Real(parameters.tau_m_ms) / 1000),
          a_(Real(parameters.tau_g_ms) / parameters.tau_m_ms),
          reset_gap_(Real(parameters.v_th_mv) - parameters.v_r_mv),
          reversal_(Real(parameters.v_th_mv) - parameters.e_k_mv),
          delta_g_(parameters.delta_g),
          refractory_s_(Real(parameters.refractory_ms) / 1000) {}

    State rest() const { return {reset_gap_, 0}; }
    Real refractory_s() const { return refractory_s_; }

    State advance(const State& state, double drive_mv, const Real& interval_s) const {
        return flow(state, drive_mv - reset_gap_, interval_s / tau_m_s_);
    }

    // Nothing if it never fires. The guess saves time and does not affect the result.
    std::optional<Real> next_spike_s(const State& state, double drive_mv, double guess_s = 0) const {
        const Real excess = drive_mv - reset_gap_;
        if (state.gap_mv <= 0) return Real(0);
        if (excess <= 0) return std::nullopt;
        if (const auto root = near(state, excess, Real(guess_s) / tau_m_s_)) return *root * tau_m_s_;
        return crossing(state, excess) * tau_m_s_;
    }

    void fire(State& state) const { state = {reset_gap_, state.g + delta_g_}; }

    // v is held at the reset value for that long.
    void hold(State& state, const Real& interval_s) const { state.g *= exp(-interval_s / (tau_m_s_ * a_)); }

  private:
    static constexpr double negligible = 1e-30;

    State flow(State state, const Real& excess, Real s) const {
        const Real g_end = state.g * exp(-s / a_);
        // g at a time u before the interval's end.
        const auto g_before = [&](const Real& u) { return Real(state.g * exp((u - s) / a_)); };
        const auto exponent = [&](const Real& u) { return Real(u + a_ * (g_before(u) - g_end)); };
        if (exponent(s) > 90) {
            // The latest start from which the exponent is still 80.
            Real low = 0;
            Real high = s;
            for (int i = 0; i < 400 && exponent(low) < 80; ++i) {
                const Real middle = low + (high - low) / 2;
                (exponent(middle) > 85 ? high : low) = middle;
            }
            state = {reversal_, g_before(high)};
            s = high;
        }
        const Real longest = a_ * 0.35;
        const Real longest_fall = expm1(Real(-0.35));
        while (s > 0 && state.g * reversal_ > negligible * abs(excess) && state.g > 1e-300) {
            Real step = s;
            const bool full = step > longest;
            if (full) step = longest;
            const bool cut = step * (1 + state.g) > 5;
            if (cut) step = 5 / (1 + state.g);
            const Real fall = full && !cut ? longest_fall : expm1(Real(-step / a_));
            state.gap_mv = taylor(state, excess, fall);
            state.g *= 1 + fall;
            s -= step;
        }
        if (s > 0) {
            state.gap_mv = state.gap_mv * exp(-s) + excess * expm1(-s);
            state.g *= exp(-s / a_);
        }
        return state;
    }

    // The gap once g has fallen by that fraction of itself.
    Real taylor(const State& state, const Real& excess, const Real& step) const {
        const Real x = a_ * state.g;
        Real power = 1;
        Real before = 0;
        Real term = state.gap_mv;
        Real sum = term;
        const Real scale = abs(state.gap_mv) + reversal_ + abs(excess);
        int small = 0;
        for (int n = 0; n < 2000 && small < 3; ++n) {
            Real next = (a_ + x - n) * term + x * before;
            if (n == 0) next += a_ * excess - x * reversal_;
            if (n == 1) next -= x * reversal_;
            next /= n + 1;
            before = term;
            term = next;
            power *= step;
            sum += term * power;
            small = n > 2 && abs(term * power) < scale * 1e-33 ? small + 1 : 0;
        }
        return sum;
    }

    // A root of z is the root.
    std::optional<Real> near(const State& start, const Real& excess, Real s) const {
        for (int i = 0; s > 0 && i < 4; ++i) {
            const State there = flow(start, excess, s);
            const Real next = s + there.gap_mv / -slope(there, excess);
            if (abs(next - s) <= s * 1e-11) return next;  // so the error is its square
            s = next;
        }
        return std::nullopt;
    }

    Real slope(const State& state, const Real& excess) const {
        return -(1 + state.g) * state.gap_mv + state.g * reversal_ - excess;
    }

    Real crossing(const State& start, const Real& excess) const {
        // Without conductance it comes earlier (and below E_k, later than from E_k).
        const Real rest = start.gap_mv < reversal_ ? start.gap_mv : reversal_;
        Real low = 0;
        State at_low = start;
        Real high = log1p(Real(rest / excess));
        for (;;) {
            const State there = flow(at_low, excess, high - low);
            if (there.gap_mv <= 0) break;
            low = high;
            at_low = there;
            high *= 2;
            if (high == 0) return 0;
        }
        // Newton from whichever side is at hand, halving where it would leave the bracket.
        const Real origin = low;
        const State from = at_low;
        Real s = high;
        for (int i = 0; i < 400; ++i) {
            const State there = flow(from, excess, s - origin);
            (there.gap_mv > 0 ? low : high) = s;
            Real next = s - there.gap_mv / slope(there, excess);
            if (!(next > low && next < high)) next = low + (high - low) / 2;
            if (abs(next - s) <= abs(s) * 1e-30) return next;
            s = next;
        }
        return s;
    }

    Real tau_m_s_;
    Real a_;
    Real reset_gap_;
    Real reversal_;
    Real delta_g_;
    Real refractory_s_;
};

}  // namespace afferent::reference
