// Proportions and their differences in per cent and points, for people and for programs.
#pragma once

#include <string>

#include "afferent/runtime/summary.hpp"
#include "afferent/studies/trial/proportion_interval.hpp"

namespace afferent {

double percent(const Proportion& proportion);

// "12.35"; "-" where it is not finite.
std::string fixed(double value, int decimals);
// The 95 % interval in per cent: "11.9 to 12.8".
std::string range_of(const Proportion& proportion);
// In points: "+1.20 (0.80 to 1.60)".
std::string points(const Estimated& estimated);

// Null where the value is not finite.
Summary known(double value);
// <name>_pct, <name>_low_pct and <name>_high_pct.
void add_percent(Summary& summary, const std::string& name, const Proportion& proportion);
Summary summary_of(const Estimated& estimated, double scale, const std::string& unit);

}  // namespace afferent
