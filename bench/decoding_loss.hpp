// What lost packets do to the error of the force and to what the decoders say of it.
#pragma once

#include <filesystem>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "bench/touch.hpp"

namespace afferent {

// Each packet is lost by itself with this probability; five draws of them, the same for every decoder.
inline constexpr double lost_part_of_packets = 0.1;

// Against what can be decoded, in packets of 5 ms and ticks of 100 us.
struct LossRow {
    std::string scene;
    std::uint32_t elements;
    std::string decoder;
    double lossless_rms_n, rms_n;
    double lossless_coverage_95, coverage_95;
    double ratio() const noexcept { return rms_n / lossless_rms_n; }
};

// Of all touches, for the sliding window and the filter. `progress` is told the fraction that is done, from
// one thread at a time.
std::vector<LossRow> measure_loss(const std::vector<Touch>& touches,
                                  const std::function<void(double)>& progress);

// loss.csv. Throws std::runtime_error where it cannot be written.
void write_loss(const std::vector<LossRow>& rows, const std::filesystem::path& folder);
void print_loss(const std::vector<LossRow>& rows, std::ostream& out);

}  // namespace afferent
