// Parameters of the stimuli that touch the skin. Included by whoever builds a scene with touches.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>

#include "afferent/runtime/time.hpp"

namespace afferent {

// The wave that spreads from an indenter: hand/indenter_wave.hpp.
struct SkinWave {
    double speed_m_per_s = 8;
    double depth_mm = 2.75;
    double reach_mm = 60;
    bool operator==(const SkinWave&) const = default;

    Duration delay(double distance_mm) const noexcept {
        return rounded(Seconds(1e-3 * distance_mm / speed_m_per_s));
    }
};

// The skin as an elastic half-space. The defaults are those of docs/afferents.md.
struct ElasticSkin {
    double modulus_kpa = 50;
    double poisson = 0.4;
    std::optional<SkinWave> wave = {};
    bool operator==(const ElasticSkin&) const = default;

    // E* = E / (1 − ν²)
    double contact_modulus_n_per_mm2() const noexcept { return 1e-3 * modulus_kpa / (1 - poisson * poisson); }
};

// The time course of a stimulus, as a factor on its load: it ramps up, holds, ramps down, and may vibrate.
//
//     ramp(t) · max(0, 1 + vibration · sin(2π vibration_hz · (t − begin)))
struct Press {
    double begin_s = 0;
    double rise_s = 0;
    double hold_s = 1e9;
    double fall_s = 0;
    double vibration_hz = 0;
    double vibration = 0;  // amplitude, relative to the load
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
    // Seconds since the beginning of the press.
    double since(TimePoint time) const noexcept { return seconds(time) - begin_s; }
};

// A rounded edge that slides over the skin.
struct SlidingEdgeParameters {
    double direction_deg = 0;  // of the motion; the edge is perpendicular to it
    double speed_mm_per_s = 20;
    double begin_mm = -10;  // its position along the direction when it begins to press
    double half_width_mm = 0.5;
    double peak_kpa = 20;
    Press press = {};
    bool operator==(const SlidingEdgeParameters&) const = default;
};

// The shape of an indenter's tip.
enum class IndenterTip { flat, sphere };

// A probe that presses into the skin, holds, vibrates or slides.
struct IndenterParameters {
    double x_mm = 0;  // of its position when it begins to press
    double y_mm = 0;
    double direction_deg = 0;
    double speed_mm_per_s = 0;
    IndenterTip tip = IndenterTip::sphere;
    double radius_mm = 1;  // of the punch or the sphere
    double force_n = 0.1;
    std::optional<double> depth_mm = {};  // if given, replaces the force
    Press press = {};
    bool operator==(const IndenterParameters&) const = default;
};

// The pad of a fingertip that rests on a surface: an ellipse with its axes along x and y. The skin is an
// elastic foundation (Johnson, Contact Mechanics, 1985, section 4.3), whose pressure is proportional to the
// depth of the surface in it. The pad is round, so that on a flat surface
//
//     p = load · peak − peak · ρ²        ρ² = (2x/width)² + (2y/height)²
//
// where that is positive. The load is relative to the depth.
struct Pad {
    double x_mm = 0;  // of its centre
    double y_mm = 0;
    double width_mm = 10;
    double height_mm = 10;
    double peak_kpa = 10;
    double stiffness_kpa_per_mm = 30;
    bool operator==(const Pad&) const = default;

    // At least 0.
    double smooth_kpa(double x, double y, double load) const noexcept {
        const double u = 2 * (x - x_mm) / width_mm;
        const double v = 2 * (y - y_mm) / height_mm;
        return std::max(0.0, peak_kpa * (load - u * u - v * v));
    }
};

// Self-affine roughness, as of most surfaces: waves between two lengths in random phases, whose power
// spectral density falls as q^(−2(1 + H)) with the Hurst exponent H (Persson et al. 2005, J Phys Condens
// Matter 17:R1).
struct Roughness {
    double rms_mm = 0.05;  // of the heights
    double longest_mm = 4;
    double shortest_mm = 0.5;
    double hurst = 0.8;
    std::uint32_t seed = 1;
    bool operator==(const Roughness&) const = default;
};

// A point of a profile of the grip force.
struct GripPoint {
    double time_s = 0;
    double force_n = 0;
    bool operator==(const GripPoint&) const = default;
};

}  // namespace afferent
