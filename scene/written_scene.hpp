// A scene as its text has it: a message, whose shorthands are not resolved yet.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "afferent/proto/scene.pb.h"
#include "afferent/scene/setting.hpp"

namespace afferent {

// Puts the setting in place. Adds the paths of the fields that it has written, such as
// "patch[1].neuron.delta_g"; returns what is wrong with it, if anything is.
std::optional<std::string> put(proto::Scene& scene, const Setting& setting,
                               std::vector<std::string>& written);

// The parser's message about a field that there is not, in our words and with the nearest name that there is;
// any other as it is.
std::string with_nearest_name(const std::string& message);

inline constexpr int deepest_nesting = 16;

}  // namespace afferent
