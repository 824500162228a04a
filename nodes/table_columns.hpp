// What the columns of a table of forces are in.
#pragma once

#include <string>
#include <vector>

#include "afferent/io/files/column_unit.hpp"
#include "afferent/nodes/patch_sensors.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// All columns are of one quantity. What they hold, times their factors, is in newtons, counts or volts.
struct TableColumns {
    Quantity quantity;
    std::vector<double> factors;
};

// `unit` stands for that of columns whose names have none. The error says what to do about a column that is
// of nothing that a table may hold; it has no place.
Result<TableColumns> table_columns(const std::vector<std::string>& names, scene::TableUnit unit);

// Makes counts of volts: the factors then go to the counts of each element's own sensor.
void volts_to_counts(TableColumns& columns, const Plan& plan);

}  // namespace afferent
