// A chip on a serial device.
#pragma once

#include <memory>

#include "afferent/nodes/chip_device.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// Opens the device of the plan's scene, whose source is a chip. The error names the field and the system's
// reason. When the line fails later, it is opened again as soon as that can be. Reads on a thread of its own.
Result<std::unique_ptr<ChipDevice>> open_chip_line(const Plan& plan);

}  // namespace afferent
