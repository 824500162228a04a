// How the bandwidth benchmark shows what it found: as files, as a picture, and to a person.
#pragma once

#include <filesystem>

#include "bench/bandwidth_bench.hpp"

namespace afferent {

// bandwidth.csv and transport.csv. Throws std::runtime_error where they cannot be written.
void write_bandwidth(const Bandwidth& bandwidth, const std::filesystem::path& folder);
// bandwidth.svg and .png of the grasp, where gnuplot is installed. Throws std::runtime_error where it fails.
void draw_bandwidth(const Bandwidth& bandwidth, const std::filesystem::path& folder);
// The default link and each alternative, and where events lose, on standard output.
void print_bandwidth(const Bandwidth& bandwidth);

}  // namespace afferent
