// How `bench decoding --not-as-told` shows what it found: as a file, as a picture, and to a person.
#pragma once

#include <filesystem>
#include <ostream>
#include <vector>

#include "bench/robust_bench.hpp"

namespace afferent {

// robust.csv. Throws std::runtime_error where it cannot be written.
void write_robustness(const std::vector<RobustRow>& rows, const std::filesystem::path& folder);
// robust.svg and .png, where gnuplot is installed: the RMS error of every decoder by case. Throws
// std::runtime_error where it fails.
void draw_robustness(const std::vector<RobustRow>& rows, const std::filesystem::path& folder);
// A line for each case, over its scenes, in Markdown.
void print_robust_cases(const std::vector<RobustRow>& rows, std::ostream& out);
// Every row, with all that is measured of it.
void print_robust_rows(const std::vector<RobustRow>& rows, std::ostream& out);

}  // namespace afferent
