// Recorded samples that a program holds in memory, in place of the files that its scene names.
#pragma once

#include <optional>

#include "afferent/io/files/scan_set.hpp"
#include "afferent/nodes/emg.hpp"

namespace afferent {

// Each serves where the scene names a table of its kind: `source { table }`, whose column says by its ending
// what the values are, and `hand { emg_table }`.
struct GivenTables {
    std::optional<ScanSet> forces = {};
    std::optional<EmgTable> emg = {};
};

}  // namespace afferent
