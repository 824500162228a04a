// What only the text of a scene has: every_patch, kinds, tables of places. They are resolved before the scene
// is read.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "afferent/proto/scene.pb.h"

namespace afferent {

// The index in the text of each patch of the scene.
using Written = std::vector<std::size_t>;

Written resolve_shorthands(proto::Scene& scene);

// What is wrong with the kinds of a patch, and the field that it is about.
std::optional<std::pair<std::string, std::string>> wrong_kinds(const proto::Patch& shared,
                                                               const proto::Patch& own);

bool has_stimuli(const proto::Source& source);

// Puts the places of a table into the patch, so that a scene, and a recording with it, stands alone. Returns
// what is wrong with the table.
std::optional<std::string> read_places(proto::Patch& patch, const std::filesystem::path& folder);

}  // namespace afferent
