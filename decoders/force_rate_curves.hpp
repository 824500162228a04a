// The force–rate curves of afferents, computed from their neurons.
#pragma once

#include "afferent/decoders/decoded_afferents.hpp"
#include "afferent/decoders/force_rate_curve.hpp"

namespace afferent {

// From the grip force to the rate of one afferent of the group, up to largest_n. Throws ParameterError if it
// is silent over the whole range.
ForceRateCurve group_curve(const DecodedAfferents::Group& group, RateKind kind, double largest_n);

// From the grip force to the sum of the rates of all afferents that have a share of it; of more than 1,024
// different ones, a sample of them stands for all. Throws ParameterError if there is none, or if one of them
// is silent over the whole range.
ForceRateCurve pooled_curve(const DecodedAfferents& afferents, RateKind kind);

}  // namespace afferent
