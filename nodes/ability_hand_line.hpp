// An Ability Hand on a serial device.
#pragma once

#include <memory>

#include "afferent/nodes/hand_device.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// Opens the device of the plan's scene, which has an ability_hand. The error names the field and the system's
// reason. When the line fails later, it is opened again as soon as that can be.
Result<std::unique_ptr<HandDevice>> open_ability_hand(const Plan& plan);

}  // namespace afferent
