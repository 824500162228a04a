// The afferents of a patch: places, receptive fields, and spread of parameters. Included with scene.hpp by
// whoever builds a scene.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "afferent/encoders/outline.hpp"
#include "afferent/scene/fields.hpp"

namespace afferent {

void each_field(Is<Position> auto& place, auto&& f) {
    f(within("x_mm", -1000, 1000), place.x_mm);
    f(within("y_mm", -1000, 1000), place.y_mm);
}

namespace scene {

// The weight of an element in a receptive field.
struct Weight {
    std::uint32_t element = 0;
    double weight = 1;
    bool operator==(const Weight&) const = default;
    static void fields(auto& self, auto&& f) {
        f(within("element", 0, most_addresses - 1), self.element);
        f(above("weight", 0, 1e6), self.weight);
    }
};

// A receptive field: the elements that an afferent reads.
struct Field {
    std::vector<Weight> weight = {};
    bool operator==(const Field&) const = default;
    static void fields(auto& self, auto&& f) { f("weight", self.weight); }
};

struct Rectangle {
    static constexpr const char* alternative = "rectangle";
    double width_mm = 10;
    double height_mm = 10;
    bool operator==(const Rectangle&) const = default;
    static void fields(auto& self, auto&& f) {
        f(within("width_mm", 0.05, 1000), self.width_mm);
        f(within("height_mm", 0.05, 1000), self.height_mm);
    }
};

struct Ellipse {
    static constexpr const char* alternative = "ellipse";
    double width_mm = 10;
    double height_mm = 10;
    bool operator==(const Ellipse&) const = default;
    static void fields(auto& self, auto&& f) {
        f(within("width_mm", 0.05, 1000), self.width_mm);
        f(within("height_mm", 0.05, 1000), self.height_mm);
    }
};

struct Outline {
    std::variant<Rectangle, Ellipse> shape = {};
    double pitch_mm = 1;
    Position centre = {};  // on the body map
    bool operator==(const Outline&) const = default;
    static void fields(auto& self, auto&& f) {
        f.arms(self.shape);
        f(within("pitch_mm", 0.05, 1000), self.pitch_mm);
        f("centre", self.centre);
    }
};

struct Afferents {
    double per_cm2 = 100;
    double jitter = 0;
    double field_sd_mm = 1;
    std::vector<Position> place = {};
    bool operator==(const Afferents&) const = default;
    static void fields(auto& self, auto&& f) {
        f(within("per_cm2", 0.01, 1e5), self.per_cm2);
        f(within("jitter", 0, 1), self.jitter);
        f(within("field_sd_mm", 0.01, 100), self.field_sd_mm);
        f("place", self.place);
    }
};

struct Normal {
    static constexpr const char* alternative = "normal";
    double mean = 1;
    double sd = 0;
    bool operator==(const Normal&) const = default;
    static void fields(auto& self, auto&& f) {
        f(within("mean", 0, 1e6), self.mean);
        f(within("sd", 0, 1e6), self.sd);
    }
};

struct LogNormal {
    static constexpr const char* alternative = "log_normal";
    double median = 1;
    double sigma = 0;
    bool operator==(const LogNormal&) const = default;
    static void fields(auto& self, auto&& f) {
        f(above("median", 0, 1e6), self.median);
        f(within("sigma", 0, 3), self.sigma);
    }
};

struct Uniform {
    static constexpr const char* alternative = "uniform";
    double lowest = 1;
    double highest = 1;
    bool operator==(const Uniform&) const = default;
    static void fields(auto& self, auto&& f) {
        f(within("lowest", 0, 1e6), self.lowest);
        f(within("highest", 0, 1e6), self.highest);
    }
};

using Distribution = std::variant<Normal, LogNormal, Uniform>;

struct TimeClass {
    double part = 1;
    double tau_m = 1;
    double tau_g = 1;
    bool operator==(const TimeClass&) const = default;
    static void fields(auto& self, auto&& f) {
        f(above("part", 0, 1e6), self.part);
        f(within("tau_m", 1e-6, 1e6), self.tau_m);
        f(within("tau_g", 1e-6, 1e6), self.tau_g);
    }
};

// Absent distributions: the same value for all afferents.
struct Spread {
    std::optional<Distribution> gain = {};
    std::optional<Distribution> threshold = {};
    std::optional<Distribution> delta_g = {};
    std::optional<Distribution> field_sd = {};
    std::optional<Distribution> phase = {};
    std::vector<TimeClass> time_class = {};
    bool operator==(const Spread&) const = default;
    static void fields(auto& self, auto&& f) {
        f("gain", self.gain);
        f("threshold", self.threshold);
        f("delta_g", self.delta_g);
        f("field_sd", self.field_sd);
        f("phase", self.phase);
        f("time_class", self.time_class);
    }
};

}  // namespace scene

// Throws ParameterError unless every distribution of a factor has only positive values.
void check(const scene::Spread& spread);

Outline outline_of(const scene::Outline& outline);

// "gain, phase"; empty: the afferents are alike.
std::string differences(const scene::Spread& spread, bool has_positions);

}  // namespace afferent
