// Stimuli on the skin, as a source of samples. Included with scene.hpp by whoever builds a scene.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "afferent/hand/stimulus_parameters.hpp"
#include "afferent/scene/fields.hpp"

namespace afferent {

void each_field(Is<Pad> auto& pad, auto&& f) {
    f(within("x_mm", -10000, 10000), pad.x_mm);
    f(within("y_mm", -10000, 10000), pad.y_mm);
    f(within("width_mm", 0.01, 1000), pad.width_mm);
    f(within("height_mm", 0.01, 1000), pad.height_mm);
    f(within("peak_kpa", 0, 1e6), pad.peak_kpa);
    f(within("stiffness_kpa_per_mm", 0, 1e6), pad.stiffness_kpa_per_mm);
}

void each_field(Is<Press> auto& press, auto&& f) {
    f(within("begin_s", 0, 1e9), press.begin_s);
    f(within("rise_s", 0, 1e9), press.rise_s);
    f(within("hold_s", 0, 1e9), press.hold_s);
    f(within("fall_s", 0, 1e9), press.fall_s);
    f(within("vibration_hz", 0, 1e5), press.vibration_hz);
    f(within("vibration", 0, 1000), press.vibration);
}

void each_field(Is<SkinWave> auto& wave, auto&& f) {
    f(within("speed_m_per_s", 0.1, 1e4), wave.speed_m_per_s);
    f(within("depth_mm", 0.1, 1000), wave.depth_mm);
    f(within("reach_mm", 1, 3000), wave.reach_mm);
}

void each_field(Is<ElasticSkin> auto& skin, auto&& f) {
    f(within("modulus_kpa", 0.001, 1e9), skin.modulus_kpa);
    f(within("poisson", 0, 0.5), skin.poisson);
    f("wave", skin.wave);
}

namespace scene {

using ProfilePoint = GripPoint;

using Edge = SlidingEdgeParameters;
using Indenter = IndenterParameters;

struct Grating {
    double period_mm = 2;
    double ridge_mm = 1;
    double depth_mm = 0.5;
    Pad pad = {};
    double direction_deg = 0;
    double speed_mm_per_s = 20;
    Press press = {};
    bool operator==(const Grating&) const = default;
    static void fields(auto& self, auto&& f) {
        f("pad", self.pad);
        f(within("direction_deg", -360, 360), self.direction_deg);
        f(within("speed_mm_per_s", 0, 10000), self.speed_mm_per_s);
        f(within("period_mm", 0.01, 1000), self.period_mm);
        f(within("ridge_mm", 0, 1000), self.ridge_mm);
        f(within("depth_mm", 0, 1000), self.depth_mm);
        f("press", self.press);
    }
};

struct Dots {
    double spacing_mm = 3;
    double diameter_mm = 0.7;
    double depth_mm = 0.5;
    Pad pad = {};
    double direction_deg = 0;
    double speed_mm_per_s = 20;
    Press press = {};
    bool operator==(const Dots&) const = default;
    static void fields(auto& self, auto&& f) {
        f("pad", self.pad);
        f(within("direction_deg", -360, 360), self.direction_deg);
        f(within("speed_mm_per_s", 0, 10000), self.speed_mm_per_s);
        f(within("spacing_mm", 0.01, 1000), self.spacing_mm);
        f(within("diameter_mm", 0.001, 1000), self.diameter_mm);
        f(within("depth_mm", 0, 1000), self.depth_mm);
        f("press", self.press);
    }
};

struct Texture : Roughness {
    Pad pad = {};
    double direction_deg = 0;
    double speed_mm_per_s = 20;
    Press press = {};
    bool operator==(const Texture&) const = default;
    static void fields(auto& self, auto&& f) {
        f("pad", self.pad);
        f(within("direction_deg", -360, 360), self.direction_deg);
        f(within("speed_mm_per_s", 0, 10000), self.speed_mm_per_s);
        f(within("rms_mm", 0, 100), self.rms_mm);
        f(within("longest_mm", 0.01, 1000), self.longest_mm);
        f(within("shortest_mm", 0.01, 1000), self.shortest_mm);
        f(within("hurst", 0, 1), self.hurst);
        f(within("seed", 0, 4294967295.0), self.seed);
        f("press", self.press);
    }
};

struct Contact {
    std::optional<std::string> patch = {};  // whose centre is the origin; absent: that of the body map
    double x_mm = 0;
    double y_mm = 0;
    // Absent: contacts without a share divide the rest of the grip force equally.
    std::optional<double> share = {};
    double radius_mm = 8;
    bool operator==(const Contact&) const = default;
    static void fields(auto& self, auto&& f) {
        f("patch", self.patch);
        f(within("x_mm", -10000, 10000), self.x_mm);
        f(within("y_mm", -10000, 10000), self.y_mm);
        f(within("share", 0, 1), self.share);
        f(within("radius_mm", 0.001, 1000), self.radius_mm);
    }
};

struct Grasp {
    std::vector<ProfilePoint> point = {};
    std::vector<Contact> contact = {};
    bool operator==(const Grasp&) const = default;
    static void fields(auto& self, auto&& f) {
        f("point", self.point);
        f("contact", self.contact);
    }
};

// Stimuli on the skin, whose pressures add up.
struct Touch {
    static constexpr const char* alternative = "";
    ElasticSkin skin = {};
    std::vector<Edge> edge = {};
    std::vector<Indenter> indenter = {};
    std::vector<Grating> grating = {};
    std::vector<Dots> dots = {};
    std::vector<Texture> texture = {};
    std::vector<Grasp> grasp = {};
    bool operator==(const Touch&) const = default;
    static void fields(auto& self, auto&& f) {
        f("skin", self.skin);
        f("edge", self.edge);
        f("indenter", self.indenter);
        f("grating", self.grating);
        f("dots", self.dots);
        f("texture", self.texture);
        f("grasp", self.grasp);
    }
};

}  // namespace scene

void each_field(Is<GripPoint> auto& point, auto&& f) {
    f(within("time_s", 0, 1e9), point.time_s);
    f(within("force_n", 0, 1e6), point.force_n);
}

void each_field(Is<SlidingEdgeParameters> auto& edge, auto&& f) {
    f(within("direction_deg", -360, 360), edge.direction_deg);
    f(within("speed_mm_per_s", 0, 10000), edge.speed_mm_per_s);
    f(within("begin_mm", -10000, 10000), edge.begin_mm);
    f(within("half_width_mm", 0.001, 1000), edge.half_width_mm);
    f(within("peak_kpa", 0, 1e6), edge.peak_kpa);
    f("press", edge.press);
}

void each_field(Is<IndenterParameters> auto& indenter, auto&& f) {
    f(within("x_mm", -10000, 10000), indenter.x_mm);
    f(within("y_mm", -10000, 10000), indenter.y_mm);
    f(within("direction_deg", -360, 360), indenter.direction_deg);
    f(within("speed_mm_per_s", 0, 10000), indenter.speed_mm_per_s);
    f("tip", indenter.tip);
    f(within("radius_mm", 0.001, 1000), indenter.radius_mm);
    f(within("force_n", 0, 1e6), indenter.force_n);
    f(within("depth_mm", 0, 1000), indenter.depth_mm);
    f("press", indenter.press);
}

struct Scene;
class SceneFaults;

// Throws ParameterError unless there are points, with times that increase.
void check_points(const std::vector<scene::ProfilePoint>& points, const std::string& field);
void check(const scene::Touch& touch, const Scene& scene, SceneFaults& faults);

// The direction of the first stimulus, counted from x towards y; 0 if it does not move.
double direction_deg(const scene::Touch& touch);

}  // namespace afferent
