// What a search for gains found: for people, for programs, as a table and as a picture.
#pragma once

#include <filesystem>
#include <ostream>
#include <vector>

#include "afferent/io/pictures/gnuplot.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/runtime/summary.hpp"
#include "afferent/studies/trial/gain_search.hpp"

namespace afferent {

// The fronts, and how the chosen gains compare on the objects that they were not chosen on.
Summary summary_of(const std::vector<GainFront>& fronts);
void print_gains(const std::vector<GainFront>& fronts, std::ostream& out);
// A row for each gain of a front. `unreachable`: the file cannot be written.
Result<void> write_gains(const std::vector<GainFront>& fronts, const std::filesystem::path& file);
// Broken against dropped objects, held out, with 95 % intervals, and how many may be dropped.
Drawing draw_gains(const std::vector<GainFront>& fronts, double most_dropped,
                   const std::filesystem::path& stem);

// The scene, with the gain that was chosen for each condition.
Scene with_chosen_gains(Scene scene, const std::vector<GainFront>& fronts);

}  // namespace afferent
