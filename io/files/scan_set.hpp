// Recorded scans: a force for each element, or an image of forces, at each of their times.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "afferent/runtime/result.hpp"

namespace afferent {

// A value for each scan, row and column, in this order; where there is one for each element, one row. The
// bytes are as they come through a pipe between two programs of one build, so that they are not held twice.
class ScanSet {
  public:
    // Values that a set has at most: 256 MiB of them.
    static constexpr std::uint64_t most_values = std::uint64_t{1} << 25;

    struct Head {
        std::uint64_t format = 0x3174'6573'6e61'6373;  // "scanset1"
        std::uint64_t scans = 0;
        std::uint64_t rows = 1;
        std::uint64_t columns = 0;
        std::uint64_t is_image = 0;
    };

    // Checked: the bytes, which are the head, then the times, then the values, may come from a program that
    // has read a hostile file.
    static Result<ScanSet> of(std::vector<std::byte> bytes);
    // The same from memory: a time for each scan, and rows × columns values for each time.
    static Result<ScanSet> of(std::span<const double> times_s, std::size_t rows, std::size_t columns,
                              bool is_image, std::span<const double> values);

    std::size_t scans() const noexcept { return head_.scans; }
    std::size_t rows() const noexcept { return head_.rows; }
    std::size_t columns() const noexcept { return head_.columns; }
    bool is_image() const noexcept { return head_.is_image != 0; }
    double time_s(std::size_t scan) const noexcept { return number(scan); }
    // Fills in the values of a scan, row by row.
    void copy(std::size_t scan, std::span<double> values) const noexcept;

  private:
    // The index-th after the head.
    double number(std::size_t index) const noexcept;

    Head head_;
    std::vector<std::byte> bytes_;
};

}  // namespace afferent
