// The results of `bench decoding --not-as-told` as a file, as a picture, and as text.
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
// Prints a Markdown table with a line for each case, in the mean over its scenes.
void print_robust_cases(const std::vector<RobustRow>& rows, std::ostream& out);
// Prints every row with all its scores.
void print_robust_rows(const std::vector<RobustRow>& rows, std::ostream& out);

}  // namespace afferent
