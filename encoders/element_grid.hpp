// The elements of a patch in two dimensions, and the receptive fields of afferents that lie among them.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "afferent/encoders/outline.hpp"
#include "afferent/encoders/receptive_fields.hpp"

namespace afferent {

// The cells of a square grid whose centres lie within an outline, row by row from the lowest y and in each
// row from the lowest x.
class ElementGrid {
  public:
    // Throws ParameterError, naming pitch_mm: at least one element, and at most `most`.
    ElementGrid(const Outline& outline, double pitch_mm, std::uint32_t most);

    std::uint32_t elements() const noexcept { return static_cast<std::uint32_t>(places_.size()); }
    const Position& place(std::uint32_t element) const noexcept { return places_[element]; }
    double pitch_mm() const noexcept { return pitch_mm_; }

    // Rows of neighbouring elements, from the lowest y. The elements of a row are first_of_row(row) and those
    // after it, at increasing x. A row may be empty.
    std::uint32_t rows() const noexcept { return static_cast<std::uint32_t>(row_begins_.size() - 1); }
    double row_y_mm(std::uint32_t row) const noexcept;
    std::uint32_t first_of_row(std::uint32_t row) const noexcept { return row_begins_[row]; }
    std::span<const Position> row(std::uint32_t row) const noexcept {
        return std::span(places_).subspan(row_begins_[row], row_begins_[row + 1] - row_begins_[row]);
    }

    // Adds the row that an afferent at that place reads: the mean pressure under Gaussian weights, as the
    // force on a square millimetre. The weights of an unbounded grid would add up to 1/pitch² (in mm), so
    // that a uniform pressure reads the same whatever the pitch; the skin beyond the outline is not pressed.
    // Elements further away than three standard deviations are left out, but for the nearest.
    void add_gaussian_field(const Position& centre, double sd_mm, FieldRows& fields) const;

  private:
    static constexpr std::uint32_t none = ~std::uint32_t{0};

    // Cells are counted from that at the lowest x and y; those outside the grid have no element.
    std::uint32_t element_at(std::int64_t column, std::int64_t row) const noexcept;
    std::uint32_t nearest(const Position& place) const noexcept;

    double pitch_mm_;
    std::int64_t columns_;
    std::vector<std::uint32_t> row_begins_;    // of elements, and the end of the last
    std::vector<std::int64_t> first_columns_;  // of each row: outlines are convex
    std::vector<Position> places_;
};

// Places of that density on a nearly square lattice within the outline, row by row; at least one. Each is
// moved at random by up to half a `jitter` of the lattice's spacing in either direction, unless that leaves
// the outline: uniform(index, axis) is in 0 to 1, and a place's index counts those before it. Throws
// ParameterError, naming per_cm2: at most `most` places.
std::vector<Position> jittered_lattice(const Outline& outline, double per_cm2, double jitter,
                                       std::uint32_t most,
                                       const std::function<double(std::uint32_t, std::uint32_t)>& uniform);

}  // namespace afferent
