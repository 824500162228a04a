// The stimuli that touch a scene's skin.
#pragma once

#include <variant>
#include <vector>

#include "afferent/hand/dots.hpp"
#include "afferent/hand/grasp_contact.hpp"
#include "afferent/hand/grating.hpp"
#include "afferent/hand/indenter.hpp"
#include "afferent/hand/indenter_wave.hpp"
#include "afferent/hand/sliding_edge.hpp"
#include "afferent/hand/texture.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// To add a stimulus, include its header above and name it here.
using AnyStimulus = std::variant<SlidingEdge, Indenter, IndenterWave, SlidingSurface<Grating>,
                                 SlidingSurface<Dots>, SlidingSurface<Texture>, GraspContact>;

// As the elements of one aperture feel them, in the order of the scene's kinds; each contact of a grasp is
// one. None where the source is another.
std::vector<AnyStimulus> stimuli_of(const Plan& plan, const Aperture& aperture);

}  // namespace afferent
