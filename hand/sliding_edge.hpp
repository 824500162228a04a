// A rounded edge that slides over the skin.
#pragma once

#include <algorithm>
#include <cmath>

#include "afferent/hand/aperture.hpp"
#include "afferent/hand/smooth_table.hpp"
#include "afferent/hand/stimulus.hpp"

namespace afferent {

// An edge at one place.
struct PressedEdge {
    const EvenTable* force_at;  // by the distance from the edge, at its peak pressure
    double reach_mm;
    Heading heading;   // the edge lies across it
    double middle_mm;  // along it
    double load;       // a part of its peak pressure

    Stretch rows() const noexcept {
        if (load <= 0) return {0, 0};
        return lies_along_rows() ? within_reach(0, heading.sin) : everywhere;
    }
    Stretch columns(double y_mm) const noexcept {
        return lies_along_rows() ? everywhere : within_reach(y_mm * heading.sin, heading.cos);
    }
    double force_n(const Position& place) const noexcept {
        return load * std::max(0.0, (*force_at)(heading.along(place.x_mm, place.y_mm) - middle_mm));
    }

  private:
    static constexpr Stretch everywhere{-1e9, 1e9};

    bool lies_along_rows() const noexcept { return std::abs(heading.cos) < 1e-12; }

    // The coordinates c for which  known + c · part  is within reach.
    Stretch within_reach(double known_mm, double part) const noexcept {
        const double a = (middle_mm - known_mm - reach_mm) / part;
        const double b = (middle_mm - known_mm + reach_mm) / part;
        return {std::min(a, b), std::max(a, b)};
    }
};

// Hertz's line contact: the pressure  p(u) = peak · √(1 − (u/a)²)  at a distance u from the middle, and 0
// beyond a, the half width.
class SlidingEdge {
  public:
    using Parameters = SlidingEdgeParameters;
    SlidingEdge(const Parameters& parameters, const Aperture& aperture);

    // Valid as long as the edge is.
    PressedEdge at(TimePoint time) const noexcept {
        return {&force_at_, reach_mm_, heading_,
                parameters_.begin_mm + parameters_.speed_mm_per_s * parameters_.press.since(time),
                parameters_.press.at(time)};
    }

  private:
    Parameters parameters_;
    Heading heading_;
    double reach_mm_;
    EvenTable force_at_;
};

static_assert(Stimulus<SlidingEdge>);

}  // namespace afferent
