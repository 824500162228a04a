#include "afferent/encoders/encoders.hpp"

#include <cstddef>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {

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
}

Transient::Transient(const Parameters& parameters)
    : gain_(parameters.gain_mv_s_per_n), bias_(parameters.bias_mv) {
    parameters.check();
}

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

EncoderInput input(const EncoderParameters& parameters) {
    return std::visit([](const auto& each) { return each.input; }, parameters);
}

double gain(const EncoderParameters& parameters) {
    return std::visit([](const auto& each) { return each.gain(); }, parameters);
}

double bias_mv(const EncoderParameters& parameters) {
    return std::visit([](const auto& each) { return each.bias_mv; }, parameters);
}

EncoderParameters with_gain(const EncoderParameters& parameters, double gain, double bias_mv) {
    return std::visit([&](const auto& each) { return EncoderParameters(each.with(gain, bias_mv)); },
                      parameters);
}

}  // namespace afferent
