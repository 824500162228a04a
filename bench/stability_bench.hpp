// Question: on which parameters and drives does each solver miss, invent or misplace a spike?
#pragma once

#include <filesystem>
#include <iosfwd>

namespace afferent::bench {

// Writes stability.csv and prints who fails where. Returns how many cases the exact solver has failed. Throws
// std::runtime_error where the file cannot be written.
std::size_t run_stability_bench(const std::filesystem::path& out, bool quick, std::ostream& report);

}  // namespace afferent::bench
