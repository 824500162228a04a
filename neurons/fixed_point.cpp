#include "afferent/neurons/fixed_point.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr std::uint32_t extra_input_bits = 5;
// As far as a bound on the next spike looks: a few scans of a fast sensor.
constexpr std::int64_t ticks_ahead = 64;

// Seven eighths of v's codes lie below the threshold.
double v_unit_mv(const FixedPointParameters& p) {
    const double codes = std::ldexp(0.875, static_cast<int>(p.state_bits));
    return (p.lif.v_th_mv - std::min(p.lif.v_r_mv, p.lif.e_k_mv)) / codes;
}

double g_unit(const FixedPointParameters& p) {
    const double interval_ms = std::max(4.0, p.lif.refractory_ms);
    const double full_scale = p.lif.delta_g / -std::expm1(-interval_ms / p.lif.tau_g_ms);
    return full_scale / (std::ldexp(1, static_cast<int>(p.state_bits)) - 1);
}

double tick_ms(const FixedPointParameters& p) { return p.tick_us / 1000.0; }

std::int64_t multiplier(const FixedPointParameters& p, double value) {
    return std::llround(std::ldexp(value, static_cast<int>(p.decay_bits)));
}

std::int64_t code(double value, double unit) { return std::llround(value / unit); }

const FixedPointParameters& checked(const FixedPointParameters& parameters) {
    parameters.check();
    return parameters;
}

}  // namespace

void FixedPointParameters::check() const {
    lif.check();
    require(tick_us >= 1 && tick_us <= 10'000, "tick_us", "1 to 10000", tick_us);
    require(state_bits >= 4 && state_bits <= 32, "state_bits", "4 to 32", state_bits);
    require(decay_bits >= 4 && decay_bits <= 24, "decay_bits", "4 to 24", decay_bits);
    require(rounding == Rounding::half_even || rounding == Rounding::truncation, "rounding",
            "half_even or truncation", static_cast<double>(rounding));
    const double v_unit = v_unit_mv(*this);
    require(code(lif.v_r_mv - lif.e_k_mv, v_unit) < code(lif.v_th_mv - lif.e_k_mv, v_unit), "state_bits",
            "enough to tell v_r from v_th", state_bits);
    require(code(lif.v_th_mv - lif.e_k_mv, v_unit) >= 1, "state_bits", "enough to tell E_k from v_th",
            state_bits);
    const std::int64_t one = std::int64_t{1} << decay_bits;
    require(multiplier(*this, std::exp(-tick_ms(*this) / lif.tau_m_ms)) < one, "decay_bits",
            "enough to tell a tick's decay of v, e^(-tick/tau_m), from none", decay_bits);
    require(lif.refractory_ms / tick_ms(*this) <= 4e9, "refractory_ms", "at most 4e9 ticks",
            lif.refractory_ms);
    if (lif.delta_g == 0) return;
    require(code(lif.delta_g, g_unit(*this)) >= 1, "state_bits", "enough to tell delta_g from 0", state_bits);
    require(multiplier(*this, std::exp(-tick_ms(*this) / lif.tau_g_ms)) < one, "decay_bits",
            "enough to tell a tick's decay of g, e^(-tick/tau_g), from none", decay_bits);
}

FixedPointParameters FixedPointParameters::with_adaptation(double delta_g) const noexcept {
    FixedPointParameters changed = *this;
    changed.lif.delta_g = delta_g;
    return changed;
}

std::string FixedPointParameters::describe() const {
    return lif.describe() + ", tick_us " + std::to_string(tick_us) + ", state_bits " +
           std::to_string(state_bits) + ", decay_bits " + std::to_string(decay_bits) + ", rounding " +
           (rounding == Rounding::half_even ? "half_even" : "truncation");
}

FixedPointLif::FixedPointLif(const FixedPointParameters& parameters)
    : e_k_mv_(checked(parameters).lif.e_k_mv),
      v_unit_mv_(v_unit_mv(parameters)),
      g_unit_(parameters.lif.delta_g > 0 ? g_unit(parameters) : 0),
      rest_input_((parameters.lif.v_r_mv - e_k_mv_) / v_unit_mv_) {
    static_assert(std::is_trivially_copyable_v<State>);
    const LifParameters& lif = parameters.lif;
    const double h_ms = tick_ms(parameters);
    const std::int64_t reset = code(lif.v_r_mv - e_k_mv_, v_unit_mv_);
    const std::int64_t codes = std::int64_t{1} << parameters.state_bits;
    const std::int64_t lowest = std::min<std::int64_t>(reset, 0);
    codes_ = {.tick_ns = std::int64_t{parameters.tick_us} * 1000,
              .threshold = code(lif.v_th_mv - e_k_mv_, v_unit_mv_),
              .reset = reset,
              .lowest = lowest,
              .highest = lowest + codes - 1,
              .one = std::int64_t{1} << parameters.decay_bits,
              .v_decay = multiplier(parameters, std::exp(-h_ms / lif.tau_m_ms)),
              .g_decay = multiplier(parameters, std::exp(-h_ms / lif.tau_g_ms)),
              .conductance = 0,
              .g_jump = lif.delta_g > 0 ? code(lif.delta_g, g_unit_) : 0,
              .g_most = codes - 1,
              .conductance_bits = 0,
              .decay_bits = parameters.decay_bits,
              .refractory_ticks = static_cast<std::uint32_t>(std::llround(lif.refractory_ms / h_ms)),
              .input_bits = parameters.state_bits + extra_input_bits,
              .rounding = parameters.rounding};
    if (codes_.g_jump == 0) return;
    // As large a shift as leaves K decay_bits wide. Where one unit of g already takes all of v, K is one.
    const double share = std::expm1(h_ms / lif.tau_m_ms) * g_unit_;
    const int exponent = share > 0 && std::isfinite(share) ? std::ilogb(share) : 0;
    const int bits = std::clamp(-1 - exponent, 0, 62 - static_cast<int>(parameters.decay_bits));
    codes_.conductance_bits = static_cast<std::uint32_t>(bits);
    codes_.conductance = multiplier(parameters, std::ldexp(std::min(1.0, share), bits));
}

double FixedPointLif::exact_input(double drive_mv) const noexcept {
    const double largest = std::ldexp(1, static_cast<int>(codes_.input_bits - 1));
    const double input = rest_input_ + drive_mv / v_unit_mv_;
    if (std::isnan(input)) return 0;  // an infinite drive against an infinite rest
    return std::clamp(input, -largest, largest - 1);
}

std::int64_t FixedPointLif::input(double drive_mv) const noexcept {
    return std::llround(exact_input(drive_mv));
}

void FixedPointLif::advance(State& state, double drive_mv, Interval dt) const noexcept {
    const std::int64_t passed_ns = state.since_tick_ns + std::llround(dt.count());
    state.since_tick_ns = static_cast<std::uint32_t>(passed_ns % codes_.tick_ns);
    const std::int64_t input = this->input(drive_mv);
    for (std::int64_t left = passed_ns / codes_.tick_ns; left > 0; --left) {
        const State before = state;
        tick(state, input);
        if (state == before) return;
    }
}

Interval FixedPointLif::search(State& state, double drive_mv, std::int64_t most_ticks) const noexcept {
    if (fires(state)) return Interval(0);
    const std::int64_t input = this->input(drive_mv);
    State now = state;  // a copy cannot be an alias of codes_
    std::int64_t ticks = 0;
    for (State before = now;; before = now) {
        tick(now, input);
        ++ticks;
        if (fires(now) || ticks == most_ticks) break;
        if (now == before) return never;
    }
    state = now;
    const std::uint32_t since_tick_ns = std::exchange(state.since_tick_ns, 0);
    return Interval(static_cast<double>(ticks * codes_.tick_ns - since_tick_ns));
}

Interval FixedPointLif::next_spike(const State& state, double drive_mv) const noexcept {
    State at_spike = state;
    return advance_to_spike(at_spike, drive_mv);
}

Interval FixedPointLif::advance_to_spike(State& state, double drive_mv) const noexcept {
    return search(state, drive_mv, std::numeric_limits<std::int64_t>::max());
}

Interval FixedPointLif::earliest_spike(const State& state, double drive_mv) const noexcept {
    State ahead = state;
    return search(ahead, drive_mv, ticks_ahead);
}

void FixedPointLif::fire(State& state) const noexcept {
    state.u = codes_.reset;
    state.g = static_cast<std::uint32_t>(std::min<std::int64_t>(state.g + codes_.g_jump, codes_.g_most));
    state.refractory_ticks = codes_.refractory_ticks;
}

// A tick does not decrease u where the u before it was higher, nor, above E_k, where g was lower. Below E_k
// conductance pulls u up, to E_k at most. So nothing is earlier than the higher of reset and E_k without g.
Interval FixedPointLif::shortest_interval(double drive_mv) const noexcept {
    State state = rest();
    state.refractory_ticks = codes_.refractory_ticks;
    if (codes_.g_jump > 0) state.u = std::max<std::int64_t>(codes_.reset, 0);
    return next_spike(state, drive_mv);
}

std::variant<FixedPointLif> smallest_neuron(const FixedPointParameters& parameters) {
    return FixedPointLif(parameters);
}

double highest_rate_hz(const FixedPointParameters& parameters, double drive_mv) {
    const Interval shortest = FixedPointLif(parameters).shortest_interval(drive_mv);
    return shortest == never ? 0 : 1000 / Milliseconds(shortest).count();
}

}  // namespace afferent
