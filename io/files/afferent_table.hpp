// The table of afferents that belongs to a table of events: what each address stands for.
#pragma once

#include <filesystem>
#include <optional>

#include "afferent/io/files/table_error.hpp"
#include "afferent/runtime/population.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// The table beside "events.csv" is "afferents.csv"; that of "x.csv" is "x.afferents.csv".
std::filesystem::path afferents_beside(const std::filesystem::path& events);

// A row for each address, from 0 on: address, patch, kind, x_mm, y_mm, element, elements and resolution_ns,
// the smallest difference between two times of its events. A cell is empty where there is nothing to tell.
std::optional<TableError> write_afferents(const std::filesystem::path& file, const Population& population,
                                          Duration resolution);

struct AfferentTable {
    Population population;
    Duration resolution = Duration(1);
};
// What was written. `malformed` names the line, and what is wrong with it.
Result<AfferentTable> read_afferents(const std::filesystem::path& file);

}  // namespace afferent
