// A rounded edge that slides over the skin.
#pragma once

#include <algorithm>
#include <cmath>

#include "afferent/hand/edge_contact.hpp"
#include "afferent/hand/stimulus.hpp"

namespace afferent {

// An edge at one place. A cell counts as a strip across the edge's direction, as wide and long as the cell:
// exact for an edge along rows or columns, and otherwise right in its sum over neighbouring cells.
struct PressedEdge {
    EdgeContact contact;
    Heading heading;   // the edge lies across it
    double middle_mm;  // along it
    double load;       // a part of its peak pressure

    Stretch rows(double width_mm) const noexcept {
        if (load <= 0) return {0, 0};
        return lies_along_rows() ? reach(0, heading.sin, width_mm) : everywhere;
    }
    Stretch columns(double y_mm, double width_mm) const noexcept {
        return lies_along_rows() ? everywhere : reach(y_mm * heading.sin, heading.cos, width_mm);
    }
    double force_n(const SkinCell& cell) const noexcept {
        const double from_mm = heading.along(cell.x_mm, cell.y_mm) - middle_mm - cell.width_mm / 2;
        return load * contact.strip_n(from_mm, from_mm + cell.width_mm);
    }

  private:
    static constexpr Stretch everywhere{-1e9, 1e9};

    bool lies_along_rows() const noexcept { return std::abs(heading.cos) < 1e-12; }

    // The coordinates c for which  known + c · part  is within reach.
    Stretch reach(double known_mm, double part, double width_mm) const noexcept {
        const double reach_mm = contact.reach_mm(width_mm);
        const double a = (middle_mm - known_mm - reach_mm) / part;
        const double b = (middle_mm - known_mm + reach_mm) / part;
        return {std::min(a, b), std::max(a, b)};
    }
};

class SlidingEdge {
  public:
    using Parameters = SlidingEdgeParameters;
    explicit SlidingEdge(const Parameters& parameters) noexcept
        : parameters_(parameters),
          heading_(Heading::of_degrees(parameters.direction_deg)),
          contact_(parameters.half_width_mm, parameters.peak_kpa) {}

    PressedEdge at(TimePoint time) const noexcept {
        return {contact_, heading_,
                parameters_.begin_mm + parameters_.speed_mm_per_s * parameters_.press.since(time),
                parameters_.press.at(time)};
    }

  private:
    Parameters parameters_;
    Heading heading_;
    EdgeContact contact_;
};

static_assert(Stimulus<SlidingEdge>);

}  // namespace afferent
