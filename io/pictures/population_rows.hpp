// The rows of a raster of spikes: afferents by their kind, and of one kind by their position.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
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

    // Kinds come in the order of their first patches, each with as many rows as it has afferents. Those of a
    // kind are equally far apart, from its largest to its smallest position along a direction (an angle from
    // x towards y), so that what slides at a constant speed is a straight line; a row may have several
    // afferents, or none. Those without a position come last, by address.
    PopulationRows(const Population& population, double direction_deg);

    const std::vector<Kind>& kinds() const noexcept { return kinds_; }
    // Of each address.
    std::uint32_t row(Address address) const noexcept { return row_[address]; }
    std::size_t kind(Address address) const noexcept { return kind_[address]; }
    std::uint32_t rows() const noexcept { return static_cast<std::uint32_t>(row_.size()); }
    // How many afferents are in each row.
    const std::vector<std::uint32_t>& afferents() const noexcept { return afferents_; }
    // The position of a row along the direction, in mm; NaN where its afferents have none.
    double along_mm(std::uint32_t row) const noexcept { return along_mm_[row]; }

  private:
    // Afferents of a kind, and how far each lies along the direction, in mm.
    using Positions = std::vector<std::pair<Address, double>>;
    void place(const Positions& positions, std::uint32_t first);

    std::vector<Kind> kinds_;
    std::vector<std::uint32_t> row_;
    std::vector<std::uint8_t> kind_;
    std::vector<std::uint32_t> afferents_;
    std::vector<double> along_mm_;
};

// The colour of a kind: those that are common for SA1, RA and PC, in shades that people of any colour vision
// tell apart; of any other kind, one of the rest.
std::string_view colour_of_kind(const std::vector<PopulationRows::Kind>& kinds, std::size_t kind);

}  // namespace afferent
