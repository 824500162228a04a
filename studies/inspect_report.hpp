// What an inspected table is: for programs, for people, and as a picture.
#pragma once

#include <ostream>

#include "afferent/io/pictures/panel_grid.hpp"
#include "afferent/runtime/summary.hpp"
#include "afferent/studies/inspect.hpp"

namespace afferent {

Summary summary_of(const TableInspection& found);
void print(const TableInspection& found, std::ostream& out);
// A panel for each of the first twelve columns.
PanelGrid picture_of(const TableInspection& found);

}  // namespace afferent
