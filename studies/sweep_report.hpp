// What a sweep came to: as a table, and as a picture.
#pragma once

#include <filesystem>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "afferent/io/pictures/scatter_picture.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/runtime/summary.hpp"
#include "afferent/studies/sweep.hpp"

namespace afferent {

// A row for each point that was reached: the settings, and the figures or the refusal.
class SweepTable {
  public:
    SweepTable(std::span<const SweepAxis> axes, std::span<const SweepPoint> points);

    // By column, without what is not known.
    const Summary::List& rows() const noexcept { return rows_; }
    void print(std::ostream& out) const;
    // As CSV. `unreachable`: the file cannot be written.
    Result<void> write(const std::filesystem::path& file) const;

  private:
    std::vector<std::string> columns_;
    Summary::List rows_;
};

// Error against bytes, or against events where there are no packets: a line for each value of the first axis.
ScatterPicture picture_of(const Scene& scene, std::span<const SweepAxis> axes,
                          std::span<const SweepPoint> points);

}  // namespace afferent
