// What a scene tells its decoder: which afferents to read, and how to decode them.
#pragma once

#include "afferent/decoders/decoders.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// Whether the scene's decoder reads that patch: it is named, or sustained where none is.
bool decodes(const Scene& scene, const Patch& patch);

DecodedAfferents decoded_afferents(const Scene& scene);

DecoderParameters decoder_parameters(const proto::Decoder& decoder);

// Parts of that decoder, built from the two.
std::vector<bool> read_addresses(const Scene& scene);
GripEstimator make_estimator(const Scene& scene);

}  // namespace afferent
