// The force–rate curves of afferents, computed from their neurons.
#pragma once

#include <cmath>
#include <limits>

#include "afferent/decoders/decoded_afferents.hpp"
#include "afferent/decoders/force_rate_curve.hpp"

namespace afferent {

// From the grip force to the rate of one afferent of the group, up to largest_n. Throws ParameterError if it
// is silent over the whole range.
ForceRateCurve group_curve(const DecodedAfferents::Group& group, RateKind kind, double largest_n);

// From the grip force to the sum of the rates of all afferents that have a share of it. It bends where their
// elements are at full scale and ends where all of them are. Of more than 1,024 different afferents, a sample
// stands for all. Throws ParameterError if there is none, or if one of them
// is silent over the whole range.
ForceRateCurve pooled_curve(const DecodedAfferents& afferents, RateKind kind);

// A sensor's noise and its last step let it read its full scale slightly early, and hysteresis lets it read
// low for good: a force counts as full scale from this part of it on.
double full_scale_fraction(const DecodedAfferents& afferents);

// What afferents have in common whose elements are all at full scale.
struct FullScale {
    // The sum of their adapted rates, the least at which they fire while the sensors are at full scale.
    double rate_hz = std::numeric_limits<double>::infinity();
    // What the sensors read at most: full scales weighed by shares, in N of grip force.
    double reading_n = 0;
    // Neurons that are alike under the same drive count together: the root of the sum of the squares of how
    // many are alike at full scale.
    double counts_as = 0;

    // Whether a rate cannot be told from that of the full scale, if that of one neuron may come out too low
    // by short_hz.
    bool is_reached(double measured_hz, double short_hz) const noexcept {
        return measured_hz > 0 && std::isfinite(rate_hz) && measured_hz + counts_as * short_hz >= rate_hz;
    }
};
// Infinite where an afferent with a share has no full scale, as nothing can be said then.
FullScale full_scale_of(const DecodedAfferents& afferents);

}  // namespace afferent
