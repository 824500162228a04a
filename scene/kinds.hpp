// The kinds of tactile afferents in the glabrous skin of the human hand, as presets of a patch.
#pragma once

#include "afferent/scene/scene.hpp"

namespace afferent::scene {

// "SA1", "RA" or "PC".
const char* name(Kind kind);

// A patch with the encoder, neuron, afferents and spread of that kind at the fingertip. Name, outline and
// sensor are the caller's. Each number has its source in kinds.cpp; docs/afferents.md compares their
// responses with the literature.
Patch preset(Kind kind);

}  // namespace afferent::scene
