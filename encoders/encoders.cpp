#include "afferent/encoders/encoders.hpp"

#include <cmath>
#include <cstddef>
#include <numbers>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {

void Rectification::check(const char* threshold_name) const {
    require(negative_ratio >= 0 && negative_ratio <= 1, "negative_ratio", "0 to 1", negative_ratio);
    require(threshold >= 0, threshold_name, ">= 0", threshold);
}

void Sustained::Parameters::check() const {
    require(gain_mv_per_n > 0, "gain_mv_per_n", "> 0", gain_mv_per_n);
    require(true, "bias_mv", "finite", bias_mv);
}

Sustained::Sustained(const Parameters& parameters)
    : gain_(parameters.gain_mv_per_n), bias_(parameters.bias_mv) {
    parameters.check();
}

void Transient::Parameters::check() const {
    require(gain_mv_s_per_n > 0, "gain_mv_s_per_n", "> 0", gain_mv_s_per_n);
    require(true, "bias_mv", "finite", bias_mv);
    rectification.check(threshold_name);
}

Transient::Transient(const Parameters& parameters)
    : gain_(parameters.gain_mv_s_per_n), bias_(parameters.bias_mv), rectified_(parameters.rectification) {
    parameters.check();
}

template <int order>
void BandLimited<order>::Parameters::check() const {
    require(gain > 0, gain_name, "> 0", gain);
    require(true, "bias_mv", "finite", bias_mv);
    require(corner_hz > 0, "corner_hz", "> 0", corner_hz);
    rectification.check(threshold_name);
}

// The derivative is the force through a filter whose response is the n-th derivative of a gamma density; no
// force within a range of width 1 gives more than that response's positive part, which is the sum of the
// rises of the (n−1)-th derivative: of s e^(−s) up to its top at s = 1, or of (s²/2 − s³/6) e^(−s), from 0 to
// its top at 3 − √3 and from its bottom at 3 + √3 to 0.
template <int order>
double BandLimited<order>::Parameters::largest_input(double range_n, std::optional<Interval>) const noexcept {
    const double corner_per_s = 2 * std::numbers::pi * corner_hz;
    if constexpr (order == 1) return rectification.largest(range_n * corner_per_s * std::exp(-1.0));
    const auto slope = [](double s) { return (s * s / 2 - s * s * s / 6) * std::exp(-s); };
    const double root = std::numbers::sqrt3;
    return rectification.largest(range_n * corner_per_s * corner_per_s * (slope(3 - root) - slope(3 + root)));
}

template <int order>
BandLimited<order>::BandLimited(const Parameters& parameters)
    : gain_(parameters.gain),
      bias_(parameters.bias_mv),
      corner_per_s_(2 * std::numbers::pi * parameters.corner_hz),
      rectified_(parameters.rectification) {
    parameters.check();
}

template class BandLimited<1>;
template class BandLimited<2>;

void DynamicSustained::Parameters::check() const {
    require(gain_mv_per_n > 0, "gain_mv_per_n", "> 0", gain_mv_per_n);
    require(true, "bias_mv", "finite", bias_mv);
    require(time > Seconds(0), "dynamic.time_ms", "> 0", Milliseconds(time).count());
    require(corner_hz > 0, "dynamic.corner_hz", "> 0", corner_hz);
}

namespace {

// Checks them before what is made of them.
const DynamicSustained::Parameters& checked(const DynamicSustained::Parameters& parameters) {
    parameters.check();
    return parameters;
}

}  // namespace

DynamicSustained::DynamicSustained(const Parameters& parameters)
    : gain_(checked(parameters).gain_mv_per_n), bias_(parameters.bias_mv), rise_(parameters.rise()) {}

template <class Inner>
void SlowlyAdapting<Inner>::Parameters::check() const {
    Inner::Parameters::check();
    require(part > 0 && part < 1, "slow_adaptation.part", "> 0 and < 1", part);
    require(slow_time > Seconds(0), "slow_adaptation.time_s", "> 0", slow_time.count());
}

template <class Inner>
SlowlyAdapting<Inner>::SlowlyAdapting(const Parameters& parameters)
    : inner_(parameters), part_(parameters.part), per_s_(1 / parameters.slow_time.count()) {
    parameters.check();
}

template class SlowlyAdapting<Sustained>;
template class SlowlyAdapting<DynamicSustained>;

namespace {

// The encoder with these parameters: the k-th of the list has the k-th parameters.
template <std::size_t k = 0>
AnyEncoder made(const EncoderParameters& parameters) {
    if (parameters.index() == k)
        return std::variant_alternative_t<k, AnyEncoder>(*std::get_if<k>(&parameters));
    if constexpr (k + 1 < std::variant_size_v<AnyEncoder>) return made<k + 1>(parameters);
    throw std::bad_variant_access();
}

}  // namespace

AnyEncoder make_encoder(const EncoderParameters& parameters) { return made(parameters); }

void check(const EncoderParameters& parameters) {
    std::visit([](const auto& each) { each.check(); }, parameters);
}

const char* name(const EncoderParameters& parameters) {
    return std::visit([](const auto& each) { return each.name; }, parameters);
}

const char* gain_name(const EncoderParameters& parameters) {
    return std::visit([](const auto& each) { return each.gain_name; }, parameters);
}

bool is_decodable(const EncoderParameters& parameters) {
    return std::visit([](const auto& each) { return each.decodable(); }, parameters);
}

bool is_tunable(const EncoderParameters& parameters) {
    return std::visit(
        [](const auto& each) {
            if constexpr (requires { each.rectification; })
                return each.input == EncoderInput::slope && each.rectification.threshold == 0;
            return true;
        },
        parameters);
}

Seconds settling(const EncoderParameters& parameters) {
    return std::visit([](const auto& each) { return each.settling(); }, parameters);
}

double largest_input(const EncoderParameters& parameters, double range_n, std::optional<Interval> sampling) {
    return std::visit([&](const auto& each) { return each.largest_input(range_n, sampling); }, parameters);
}

EncoderInput input(const EncoderParameters& parameters) {
    return std::visit([](const auto& each) { return each.input; }, parameters);
}

double gain(const EncoderParameters& parameters) {
    return std::visit([](const auto& each) { return each.gain_of_input(); }, parameters);
}

double bias_mv(const EncoderParameters& parameters) {
    return std::visit([](const auto& each) { return each.bias_mv; }, parameters);
}

EncoderParameters with_gain(const EncoderParameters& parameters, double gain, double bias_mv) {
    return std::visit([&](const auto& each) { return EncoderParameters(each.with(gain, bias_mv)); },
                      parameters);
}

}  // namespace afferent
