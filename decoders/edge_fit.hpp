// How an edge lies on the skin, by the first spikes of a touch.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "afferent/decoders/pressure_fit.hpp"
#include "afferent/decoders/readout.hpp"

namespace afferent {

// An edge that slides reaches one afferent after another: the plane
//
//     first spike = t₀ + s·x + (a polynomial of the second degree in ln θ),      s = n / speed
//
// is fitted to the times of their first spikes, by least squares that weigh down what is far off (Tukey's
// biweight). n is the direction in which it moves. θ is an afferent's threshold, relative to the others: who
// is more sensitive feels the edge earlier.
//
// An edge that is pressed on reaches all of them at once, and drives those the hardest that lie beneath it:
// they fire first. θ divided by the latency stands for the pressure, and no spike for none; the edge is the
// longer axis of the contact that fits them (pressure_fit.hpp).
//
// It has been a slide where the plane leaves less than half of the spread of the times, and s is ten standard
// deviations long. Allocates nothing after construction.
class EdgeFit {
  public:
    struct Afferent {
        SkinField field;
        double threshold;  // > 0, in any unit
        friend bool operator==(const Afferent&, const Afferent&) = default;
    };
    struct First {
        std::uint32_t afferent;
        double time_s;  // from the first of all
    };
    using Edge = EdgeEstimate;

    // Fewer tell nothing.
    static constexpr std::size_t fewest = 8;
    // The deviation of an orientation of which nothing is known.
    static constexpr double unknown_deg = 52;

    // At least `fewest` afferents. Throws ParameterError.
    explicit EdgeFit(const std::vector<Afferent>& afferents);

    // For at least `fewest` first spikes, each of another afferent.
    Edge operator()(std::span<const First> firsts) noexcept;

    std::size_t afferents() const noexcept { return fit_.fields().size(); }
    std::size_t heap_bytes() const noexcept;

  private:
    struct Plane {
        bool found = false;
        double x_s_per_mm = 0, y_s_per_mm = 0;  // the slowness s
        double xx = 0, xy = 0, yy = 0;          // its covariance
        double spread_s = 0;                    // the standard deviation of its residuals
    };
    // The plane has five unknowns: t₀, both components of s, and two coefficients of the polynomial. row() is
    // what they are multiplied by.
    static constexpr std::size_t unknowns = 5;
    std::array<double, unknowns> row(const First& first) const noexcept;
    Plane plane(std::span<const First> firsts) noexcept;
    double spread(std::size_t count) noexcept;
    Edge slid(const Plane& plane) const noexcept;
    Edge pressed(std::span<const First> firsts) noexcept;

    PressureFit fit_;
    std::vector<double> thresholds_;
    std::vector<double> logs_;  // of the thresholds, from −1 to 1
    std::vector<double> off_;
    std::vector<double> sorted_;
    std::vector<PressureFit::Reading> readings_;
};

}  // namespace afferent
