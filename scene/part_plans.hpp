// The parts of a hand that have an estimate of their own, as its scene asks for them.
#pragma once

#include <vector>

#include "afferent/scene/plan.hpp"

namespace afferent {

// Whether the decoder reads the afferents of that patch.
bool is_read(const Scene& scene, const PatchPlan& patch);

// What a decoder is told of an afferent that feels the part `felt` of a force, and of it at most `felt_most`
// through one element.
DecodedAfferents::Group decoded_group(const PatchPlan& patch, std::uint32_t afferent, double felt,
                                      double felt_most);

// The parts of a plan whose patches are decided: none where the scene does not ask for them, and none of
// which the decoder reads no afferent. Within a part, and where an afferent reads several elements, the force
// is taken to be spread as the shares of the scene say; evenly, where none of them has a share.
std::vector<PartPlan> part_plans(const Plan& plan);

// The plan has at least one part. Throws ParameterError.
PartDecoders make_part_decoders(const ControllerPlan& plan);

}  // namespace afferent
