// The closed list of encoders that a scene can name, and what it asks of every one of them.
#pragma once

#include <utility>
#include <variant>

#include "afferent/encoders/sustained.hpp"
#include "afferent/encoders/transient.hpp"

namespace afferent {

// To add an encoder, include its header above and name it here. Its Parameters have the members that the
// functions below call.
using AnyEncoder = std::variant<Sustained, Transient>;

namespace detail {
template <class Encoders>
struct ParametersOf;
template <Encoder... E>
struct ParametersOf<std::variant<E...>> {
    using Type = std::variant<typename E::Parameters...>;
};
}  // namespace detail

// In the order of the encoders.
using EncoderParameters = detail::ParametersOf<AnyEncoder>::Type;

// Throws ParameterError.
AnyEncoder make_encoder(const EncoderParameters& parameters);

// Calls visit(encoder) with the encoder that has these parameters, of its own class. Throws ParameterError.
template <class Visit>
decltype(auto) visit_encoder(const EncoderParameters& parameters, Visit&& visit) {
    return std::visit(std::forward<Visit>(visit), make_encoder(parameters));
}

// Throws ParameterError, naming the field.
void check(const EncoderParameters& parameters);

// As scenes spell it: "sustained", "transient".
const char* name(const EncoderParameters& parameters);

// What the encoder multiplies by its gain; the gain in mV for one unit of it; the drive where it is 0.
EncoderInput input(const EncoderParameters& parameters);
double gain(const EncoderParameters& parameters);
double bias_mv(const EncoderParameters& parameters);
// The same kind of encoder with another gain and bias.
EncoderParameters with_gain(const EncoderParameters& parameters, double gain, double bias_mv);

}  // namespace afferent
