// The adapting neuron as a digital chip computes it: integers of a stated width on a stated tick.
#pragma once

#include <algorithm>
#include <cstdint>
#include <variant>

#include "afferent/neurons/neuron.hpp"
#include "afferent/neurons/parameters.hpp"

namespace afferent {

// With d = decay_bits, one = 2^d, u = v − E_k and b = v_r + R·I − E_k in v's unit, a tick of length h is
//
//     g := (g · D_g) >> d                                   D_g = e^(−h/tau_g)
//     u := (u · max(0, one − ((g · K) >> k))) >> d          K: e^(h/tau_m) − 1, times g's unit
//     u := (u · D_m + b · (one − D_m)) >> d                 D_m = e^(−h/tau_m)
//     u reaches v_th:  u := v_r,  g := g + Δg
//
// where every shift rounds, and u and g saturate; docs/chip.md has the constants. The order of the two
// products makes b/(1 + g) the resting point at a constant g, so that what is left of the error of the step
// is of first order in h. In the refractory period u stays and g decays.
//
// The drive counts at ticks: one that changes between two acts from the next. Ticks are counted from the
// beginning of the scene, and spikes come at ticks.
//
// Under a held drive g falls until rounding stops it, and u is then carried by a function that does not
// decrease: it moves in one direction until it stays. So a prediction ends: at a spike, or in a state that a
// tick does not change. That takes at most about (tau_m + tau_g)/h · (state_bits ln 2 + 1) ticks beside the
// refractory period, as every tick takes a fixed share of what is left, and at least one unit. From then on
// time passes at no cost.
class FixedPointLif {
  public:
    using Parameters = FixedPointParameters;
    struct State {
        std::int64_t u;
        std::uint32_t g;
        std::uint32_t refractory_ticks;  // left
        std::uint32_t since_tick_ns;

        friend bool operator==(const State&, const State&) = default;
    };

    // What a chip computes with; all that there is to know of a neuron beside its input.
    struct Codes {
        std::int64_t tick_ns = 0;
        // Codes of v_th and v_r, and the range of u.
        std::int64_t threshold = 0;
        std::int64_t reset = 0;
        std::int64_t lowest = 0;
        std::int64_t highest = 0;
        std::int64_t one = 0;
        std::int64_t v_decay = 0;            // D_m
        std::int64_t g_decay = 0;            // D_g
        std::int64_t conductance = 0;        // K
        std::int64_t g_jump = 0;             // Δg
        std::int64_t g_most = 0;             // 2^state_bits − 1
        std::uint32_t conductance_bits = 0;  // k
        std::uint32_t decay_bits = 0;        // d
        std::uint32_t refractory_ticks = 0;
        std::uint32_t input_bits = 0;  // of b, which is signed
        Rounding rounding = Rounding::half_even;

        std::int64_t shifted(std::int64_t product, std::uint32_t bits) const noexcept {
            const std::int64_t down = product >> bits;
            if (rounding == Rounding::truncation || bits == 0) return down;
            const std::int64_t rest = product - (down << bits);
            const std::int64_t half = std::int64_t{1} << (bits - 1);
            // Half of a unit rounds up to an even number.
            return down + (rest + (down & 1) > half ? 1 : 0);
        }
        friend bool operator==(const Codes&, const Codes&) = default;
    };

    // Throws ParameterError.
    explicit FixedPointLif(const FixedPointParameters& parameters);

    const Codes& codes() const noexcept { return codes_; }
    // b of a drive.
    std::int64_t input(double drive_mv) const noexcept;
    // The same before it is rounded, within the range of b.
    double exact_input(double drive_mv) const noexcept;
    // The first half of a tick: lets g decay, and returns what conductance leaves of u.
    std::int64_t shunted(State& state) const noexcept {
        const Codes& c = codes_;
        std::int64_t kept = c.one;
        if (state.g > 0) {
            state.g = static_cast<std::uint32_t>(c.shifted(state.g * c.g_decay, c.decay_bits));
            kept = std::max<std::int64_t>(0, c.one - c.shifted(state.g * c.conductance, c.conductance_bits));
        }
        return c.shifted(state.u * kept, c.decay_bits);
    }
    // One tick under that input; does not fire.
    void tick(State& state, std::int64_t input) const noexcept {
        const Codes& c = codes_;
        const std::int64_t u = shunted(state);
        if (state.refractory_ticks > 0) {
            --state.refractory_ticks;
            return;
        }
        const std::int64_t next = c.shifted(u * c.v_decay + input * (c.one - c.v_decay), c.decay_bits);
        state.u = std::clamp(next, c.lowest, c.highest);
    }
    bool fires(const State& state) const noexcept { return state.u >= codes_.threshold; }

    State rest() const noexcept { return {codes_.reset, 0, 0, 0}; }
    // Rounded down to a whole unit of v.
    State at_phase(double phase) const noexcept {
        const std::int64_t reset_gap = codes_.threshold - codes_.reset;
        return {codes_.reset + static_cast<std::int64_t>(static_cast<double>(reset_gap) * phase), 0, 0, 0};
    }
    // Intervals are whole nanoseconds.
    void advance(State& state, double drive_mv, Interval dt) const noexcept;
    Interval next_spike(const State& state, double drive_mv) const noexcept;
    // The same, and advances the state over that time; not where it is `never`.
    Interval advance_to_spike(State& state, double drive_mv) const noexcept;
    // Looks no farther than some ticks ahead.
    Interval earliest_spike(const State& state, double drive_mv) const noexcept;
    void fire(State& state) const noexcept;

    double v_mv(const State& state) const noexcept {
        return e_k_mv_ + static_cast<double>(state.u) * v_unit_mv_;
    }
    double g(const State& state) const noexcept { return state.g * g_unit_; }

    // The shortest interval between spikes under drives up to this one, whatever came before.
    Interval shortest_interval(double drive_mv) const noexcept;

  private:
    // Leaves the state after the tick at which the search ends; as it was where that is `never`.
    Interval search(State& state, double drive_mv, std::int64_t most_ticks) const noexcept;

    double e_k_mv_;
    double v_unit_mv_;
    double g_unit_;
    double rest_input_;  // v_r − E_k in v's unit
    Codes codes_;
};

std::variant<FixedPointLif> smallest_neuron(const FixedPointParameters& parameters);
double highest_rate_hz(const FixedPointParameters& parameters, double drive_mv);

}  // namespace afferent
