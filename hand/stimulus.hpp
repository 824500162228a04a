// What presses the skin: where it touches at a time, and with what force.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <numbers>

#include "afferent/runtime/event.hpp"

namespace afferent {

// Coordinates from one to another, which is not part of it.
struct Stretch {
    double from_mm;
    double to_mm;

    bool contains(double mm) const noexcept { return mm >= from_mm && mm < to_mm; }
};

// A square of skin, by its middle on the map of the body.
struct SkinCell {
    double x_mm;
    double y_mm;
    double width_mm;
};

// A pressure on the skin, which says which cells of a width it touches, rows(width) by the y and columns(y,
// width) by the x of their middles, so that nobody asks for the force on any others.
template <class P>
concept Pressure = requires(const P& pressure, double mm, const SkinCell& cell) {
    { pressure.rows(mm) } -> std::same_as<Stretch>;
    { pressure.columns(mm, mm) } -> std::same_as<Stretch>;
    { pressure.force_n(cell) } -> std::same_as<double>;
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

// The skin as an elastic half-space. The defaults are those of docs/afferents.md.
struct ElasticSkin {
    double modulus_kpa = 50;
    double poisson = 0.4;
    bool operator==(const ElasticSkin&) const = default;

    // E* = E / (1 − ν²)
    double contact_modulus_n_per_mm2() const noexcept { return 1e-3 * modulus_kpa / (1 - poisson * poisson); }
};

// When and how hard a stimulus presses, as a part of its load: it comes, holds and goes, and may vibrate.
//
//     ramp(t) · max(0, 1 + vibration · sin(2π vibration_hz · (t − begin)))
struct Press {
    double begin_s = 0;
    double rise_s = 0;
    double hold_s = 1e9;
    double fall_s = 0;
    double vibration_hz = 0;
    double vibration = 0;  // its amplitude
    bool operator==(const Press&) const = default;

    double at(TimePoint time) const noexcept {
        const double since_s = since(time);
        const double left_s = rise_s + hold_s + fall_s - since_s;
        if (since_s < 0 || left_s < 0) return 0;
        const double ramp =
            std::min({1.0, rise_s > 0 ? since_s / rise_s : 1.0, fall_s > 0 ? left_s / fall_s : 1.0});
        if (vibration == 0) return ramp;
        return ramp * std::max(0.0, 1 + vibration * std::sin(2 * std::numbers::pi * vibration_hz * since_s));
    }
    // Seconds from its beginning on.
    double since(TimePoint time) const noexcept { return seconds(time) - begin_s; }
};

}  // namespace afferent
