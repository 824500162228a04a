#include "afferent/neurons/fixed_point.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

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
      rest_input_((parameters.lif.v_r_mv - e_k_mv_) / v_unit_mv_),
      largest_input_(std::ldexp(1, static_cast<int>(parameters.state_bits + extra_input_bits - 1))),
      tick_ns_(std::int64_t{parameters.tick_us} * 1000),
      threshold_(code(parameters.lif.v_th_mv - e_k_mv_, v_unit_mv_)),
      reset_(code(parameters.lif.v_r_mv - e_k_mv_, v_unit_mv_)),
      lowest_(std::min<std::int64_t>(reset_, 0)),
      highest_(lowest_ + (std::int64_t{1} << parameters.state_bits) - 1),
      one_(std::int64_t{1} << parameters.decay_bits),
      v_decay_(multiplier(parameters, std::exp(-tick_ms(parameters) / parameters.lif.tau_m_ms))),
      g_decay_(multiplier(parameters, std::exp(-tick_ms(parameters) / parameters.lif.tau_g_ms))),
      conductance_(0),
      g_jump_(parameters.lif.delta_g > 0 ? code(parameters.lif.delta_g, g_unit_) : 0),
      g_most_((std::int64_t{1} << parameters.state_bits) - 1),
      conductance_bits_(0),
      decay_bits_(parameters.decay_bits),
      refractory_ticks_(
          static_cast<std::uint32_t>(std::llround(parameters.lif.refractory_ms / tick_ms(parameters)))),
      rounding_(parameters.rounding) {
    static_assert(std::is_trivially_copyable_v<State>);
    if (g_jump_ == 0) return;
    // As large a shift as leaves K decay_bits wide. Where one unit of g already takes all of v, K is one.
    const double share = std::expm1(tick_ms(parameters) / parameters.lif.tau_m_ms) * g_unit_;
    const int exponent = share > 0 && std::isfinite(share) ? std::ilogb(share) : 0;
    const int bits = std::clamp(-1 - exponent, 0, 62 - static_cast<int>(decay_bits_));
    conductance_bits_ = static_cast<std::uint32_t>(bits);
    conductance_ = multiplier(parameters, std::ldexp(std::min(1.0, share), bits));
}

std::int64_t FixedPointLif::quantized(double drive_mv) const noexcept {
    const double input = rest_input_ + drive_mv / v_unit_mv_;
    if (std::isnan(input)) return 0;  // an infinite drive against an infinite rest
    return std::llround(std::clamp(input, -largest_input_, largest_input_ - 1));
}

std::int64_t FixedPointLif::shifted(std::int64_t product, std::uint32_t bits) const noexcept {
    const std::int64_t down = product >> bits;
    if (rounding_ == Rounding::truncation || bits == 0) return down;
    const std::int64_t rest = product - (down << bits);
    const std::int64_t half = std::int64_t{1} << (bits - 1);
    return rest > half || (rest == half && (down & 1) != 0) ? down + 1 : down;
}

void FixedPointLif::tick(State& state, std::int64_t input) const noexcept {
    std::int64_t kept = one_;
    if (state.g > 0) {
        state.g = static_cast<std::uint32_t>(shifted(state.g * g_decay_, decay_bits_));
        kept = std::max<std::int64_t>(0, one_ - shifted(state.g * conductance_, conductance_bits_));
    }
    if (state.refractory_ticks > 0) {
        --state.refractory_ticks;
        return;
    }
    const std::int64_t u = shifted(state.u * kept, decay_bits_);
    state.u = std::clamp(shifted(u * v_decay_ + input * (one_ - v_decay_), decay_bits_), lowest_, highest_);
}

void FixedPointLif::advance(State& state, double drive_mv, Interval dt) const noexcept {
    const std::int64_t passed_ns = state.since_tick_ns + std::llround(dt.count());
    state.since_tick_ns = static_cast<std::uint32_t>(passed_ns % tick_ns_);
    const std::int64_t input = quantized(drive_mv);
    for (std::int64_t left = passed_ns / tick_ns_; left > 0; --left) {
        const State before = state;
        tick(state, input);
        if (state == before) return;
    }
}

Interval FixedPointLif::search(State state, double drive_mv, std::int64_t most_ticks) const noexcept {
    if (state.u >= threshold_) return Interval(0);
    const std::int64_t input = quantized(drive_mv);
    for (std::int64_t ticks = 1;; ++ticks) {
        const State before = state;
        tick(state, input);
        if (state.u >= threshold_ || ticks == most_ticks)
            return Interval(static_cast<double>(ticks * tick_ns_ - state.since_tick_ns));
        if (state == before) return never;
    }
}

Interval FixedPointLif::next_spike(const State& state, double drive_mv) const noexcept {
    return search(state, drive_mv, std::numeric_limits<std::int64_t>::max());
}

Interval FixedPointLif::earliest_spike(const State& state, double drive_mv) const noexcept {
    return search(state, drive_mv, ticks_ahead);
}

void FixedPointLif::fire(State& state) const noexcept {
    state.u = reset_;
    state.g = static_cast<std::uint32_t>(std::min<std::int64_t>(state.g + g_jump_, g_most_));
    state.refractory_ticks = refractory_ticks_;
}

// A tick does not decrease u where the u before it was higher, nor, above E_k, where g was lower. Below E_k
// conductance pulls u up, to E_k at most. So nothing is earlier than the higher of reset and E_k without g.
Interval FixedPointLif::shortest_interval(double drive_mv) const noexcept {
    State state = rest();
    state.refractory_ticks = refractory_ticks_;
    if (g_jump_ > 0) state.u = std::max<std::int64_t>(reset_, 0);
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
