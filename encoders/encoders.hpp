// The closed list of encoders that a scene can name, and what it asks of every one of them.
#pragma once

#include <utility>
#include <variant>

#include "afferent/encoders/band_limited.hpp"
#include "afferent/encoders/sustained.hpp"
#include "afferent/encoders/transient.hpp"

namespace afferent {

// To add an encoder, include its header above and name it here. Its Parameters have the members that the
// functions below call.
using AnyEncoder = std::variant<Sustained, DynamicSustained, SlowlyAdapting<Sustained>,
                                SlowlyAdapting<DynamicSustained>, Transient, BandTransient, Vibration>;

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

// As scenes spell it: "sustained", "transient", "vibration"; and the field of its gain.
const char* name(const EncoderParameters& parameters);
const char* gain_name(const EncoderParameters& parameters);

// Whether the drive follows from the force, or the size of its slope, of one moment: what decoders invert.
// They invert no lags, no slow adaptation, no half-wave and no threshold.
bool is_decodable(const EncoderParameters& parameters);

// Whether a gain follows from a rate at an input: not where a threshold is taken off before, nor of a change.
bool is_tunable(const EncoderParameters& parameters);

// For how long the drive goes on changing after the force has stopped to, beyond the next sample; what then
// is left is below a part in 1e9 of the largest drive.
Seconds settling(const EncoderParameters& parameters);

// What the encoder multiplies by its gain; the gain in mV for one unit of it; the drive where it is 0.
EncoderInput input(const EncoderParameters& parameters);
double gain(const EncoderParameters& parameters);
double bias_mv(const EncoderParameters& parameters);
// An upper bound on the encoder's input where forces stay within a range of that width and are sampled that
// often, or at times of their own. Infinite where there is none.
double largest_input(const EncoderParameters& parameters, double range_n, std::optional<Interval> sampling);
// The same kind of encoder with another gain and bias.
EncoderParameters with_gain(const EncoderParameters& parameters, double gain, double bias_mv);

}  // namespace afferent
