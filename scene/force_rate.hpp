// The force–rate curves of a scene, and the decoder that inverts them.
#pragma once

#include "afferent/decoders/force_rate_curve.hpp"
#include "afferent/decoders/grip_estimator.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// Whether the scene's decoder reads that patch: it is named, or sustained where none is.
bool decodes(const Scene& scene, const Patch& patch);

// By address.
std::vector<bool> read_addresses(const Scene& scene);

// From the grip force to the sum of the rates of all neurons read.
ForceRateCurve pooled_curve(const Scene& scene);

GripEstimator make_estimator(const Scene& scene);

// The grip force at which the strongest loaded element of those read is at its full scale: curves end there.
double largest_grip_n(const Scene& scene);

}  // namespace afferent
