// A plan in words.
#pragma once

#include <vector>

#include "afferent/scene/plan.hpp"

namespace afferent {

// Each part that a scene can have, whether it is built, and why.
std::vector<Plan::Part> parts_of(const Plan& plan);

}  // namespace afferent
