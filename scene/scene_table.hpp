// The tables of a scene, as files.
#pragma once

#include <functional>
#include <optional>

#include "afferent/io/files/table.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// How the scene says that its tables are to be read.
TableOptions table_options(const scene::Table& table);
TableOptions table_options(const scene::StandardInput& input);
TableOptions table_options(const scene::EmgTable& table);

// When the table of forces begins and ends. Nothing where there is none, where it cannot be read, and where
// it is a pipe, which can be read only once.
// `progress` is called while it is read through, with the part that is done.
std::optional<TableSpan> force_table_span(const Scene& scene,
                                          const std::function<void(double fraction)>& progress = {});

// What a scene that does not say its duration has for one.
double default_duration_s(const Scene& scene, const std::function<void(double fraction)>& progress = {});

}  // namespace afferent
