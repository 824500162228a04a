// Which of its two forms a patch's neurons take: by prediction, or by a sweep per frame.
#pragma once

#include <string>

#include "afferent/scene/scene.hpp"

namespace afferent {

struct Form {
    bool dense;
    Duration scan_interval;  // between two samples, where dense
    std::string reason;      // for either
};

// The sweep serves populations that are sampled by a clock; prediction serves everything. Throws
// ParameterError where the scene asks for the sweep and cannot have it.
Form form_of(const Scene& scene, const Patch& patch);

}  // namespace afferent
