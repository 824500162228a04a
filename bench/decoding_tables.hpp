// How the decoding benchmark shows what it found: as a file, as pictures, and to a person.
#pragma once

#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include "bench/decoding_bench.hpp"

namespace afferent {

// A scheme with its settings, as in "send_on_delta 1 %" and "raw12 50 Hz".
std::string name_of(const DecodingRow& row);

// decoding.csv. Throws std::runtime_error where it cannot be written.
void write_decoding(const std::vector<DecodingRow>& rows, const std::filesystem::path& folder);
// decoding-SCENE-ELEMENTS.svg and .png of each touch, where gnuplot is installed: the error against the bytes
// of the best settings of each scheme, and the limits. Throws std::runtime_error where it fails.
void draw_decoding(const std::vector<DecodingRow>& rows, const std::filesystem::path& folder);
// For each touch, the default packets and every alternative.
void print_decoding(const std::vector<DecodingRow>& rows, std::ostream& out);

}  // namespace afferent
