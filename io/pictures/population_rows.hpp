// The rows of a raster of spikes: afferents by their kind, and of one kind by their place.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "afferent/runtime/population.hpp"

namespace afferent {

class PopulationRows {
  public:
    struct Kind {
        std::string name;
        std::uint32_t first;  // of its rows
        std::uint32_t rows;
    };

    // Kinds come in the order of their first patches. Of one kind, afferents come by their place along a
    // direction, from that of x towards that of y; those without a place come last, by address.
    PopulationRows(const Population& population, double direction_deg);

    const std::vector<Kind>& kinds() const noexcept { return kinds_; }
    // Of each address.
    std::uint32_t row(Address address) const noexcept { return row_[address]; }
    std::size_t kind(Address address) const noexcept { return kind_[address]; }
    std::uint32_t rows() const noexcept { return static_cast<std::uint32_t>(row_.size()); }
    // How far along the direction the afferent of a row lies, in mm; NaN where it has no place.
    double along_mm(std::uint32_t row) const noexcept { return along_mm_[row]; }

  private:
    std::vector<Kind> kinds_;
    std::vector<std::uint32_t> row_;
    std::vector<std::uint8_t> kind_;
    std::vector<double> along_mm_;
};

// The colour of a kind: those that are common for SA1, RA and PC, in shades that people of any colour vision
// tell apart; of any other kind, one of the rest.
std::string_view colour_of_kind(const std::vector<PopulationRows::Kind>& kinds, std::size_t kind);

}  // namespace afferent
