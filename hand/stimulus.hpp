// What presses the skin: where it touches at a time, and with what force.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <numbers>

#include "afferent/hand/stimulus_parameters.hpp"
#include "afferent/runtime/position.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// Coordinates from one to another, which is not part of it.
struct Stretch {
    double from_mm;
    double to_mm;

    bool contains(double mm) const noexcept { return mm >= from_mm && mm < to_mm; }
};

// A pressure on the skin as its elements feel it, at places on the map of the body, which says which of them
// it touches, rows() by their y and columns(y) by their x, so that nobody asks for the force on any others.
template <class P>
concept Pressure = requires(const P& pressure, double mm, const Position& place) {
    { pressure.rows() } -> std::same_as<Stretch>;
    { pressure.columns(mm) } -> std::same_as<Stretch>;
    { pressure.force_n(place) } -> std::same_as<double>;
};

// A pressure that comes, moves and goes: at(time).
template <class S>
concept Stimulus = requires(const S& stimulus, TimePoint time) {
    { stimulus.at(time) } -> Pressure;
};

// A direction on the map, from that of x towards that of y.
struct Heading {
    double cos = 1;
    double sin = 0;

    static Heading of_degrees(double degrees) noexcept {
        const double angle = degrees * std::numbers::pi / 180;
        return {std::cos(angle), std::sin(angle)};
    }
    double along(double x, double y) const noexcept { return x * cos + y * sin; }
    double across(double x, double y) const noexcept { return y * cos - x * sin; }
};

}  // namespace afferent
