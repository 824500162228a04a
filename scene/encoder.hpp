// The encoder of a patch, from force to drive. Included with scene.hpp by whoever builds a scene.
#pragma once

#include <optional>
#include <variant>

#include "afferent/scene/fields.hpp"

namespace afferent {

namespace scene {

// That a force which rises drives more than one that is held.
struct Dynamic {
    double time_ms = 170;
    double corner_hz = 70;
    bool operator==(const Dynamic&) const = default;
    static void fields(auto& self, auto&& f) {
        f(above("time_ms", 0, 1e6), self.time_ms);
        f(within("corner_hz", 0.1, 1e5), self.corner_hz);
    }
};

// That a force which is held drives less and less, over seconds.
struct SlowAdaptation {
    double time_s = 8;
    double part = 0.3;
    bool operator==(const SlowAdaptation&) const = default;
    static void fields(auto& self, auto&& f) {
        f(above("time_s", 0, 1e6), self.time_s);
        f(within("part", 0.001, 0.999), self.part);
    }
};

// If absent, gain and bias are computed from the neuron's tuning.
struct Sustained {
    static constexpr const char* alternative = "sustained";
    std::optional<double> gain_mv_per_n = {};
    std::optional<double> bias_mv = {};
    std::optional<Dynamic> dynamic = {};
    std::optional<SlowAdaptation> slow_adaptation = {};
    bool operator==(const Sustained&) const = default;
    static void fields(auto& self, auto&& f) {
        f(above("gain_mv_per_n", 0, 1e12), self.gain_mv_per_n);
        f(within("bias_mv", -1e12, 1e12), self.bias_mv);
        f("dynamic", self.dynamic);
        f("slow_adaptation", self.slow_adaptation);
    }
};

struct Transient {
    static constexpr const char* alternative = "transient";
    std::optional<double> gain_mv_s_per_n = {};
    std::optional<double> bias_mv = {};
    std::optional<double> corner_hz = {};
    double negative_ratio = 1;
    double threshold_n_per_s = 0;
    bool operator==(const Transient&) const = default;
    static void fields(auto& self, auto&& f) {
        f(above("gain_mv_s_per_n", 0, 1e12), self.gain_mv_s_per_n);
        f(within("bias_mv", -1e12, 1e12), self.bias_mv);
        f(within("corner_hz", 0.1, 1e5), self.corner_hz);
        f(within("negative_ratio", 0, 1), self.negative_ratio);
        f(within("threshold_n_per_s", 0, 1e12), self.threshold_n_per_s);
    }
};

// The gain is required: it does not follow from a tuning.
struct Vibration {
    static constexpr const char* alternative = "vibration";
    std::optional<double> gain_mv_s2_per_n = {};
    std::optional<double> bias_mv = {};
    double corner_hz = 250;
    double negative_ratio = 1;
    double threshold_n_per_s2 = 0;
    bool operator==(const Vibration&) const = default;
    static void fields(auto& self, auto&& f) {
        f(above("gain_mv_s2_per_n", 0, 1e12), self.gain_mv_s2_per_n);
        f(within("bias_mv", -1e12, 1e12), self.bias_mv);
        f(within("corner_hz", 0.1, 1e5), self.corner_hz);
        f(within("negative_ratio", 0, 1), self.negative_ratio);
        f(within("threshold_n_per_s2", 0, 1e12), self.threshold_n_per_s2);
    }
};

using Encoder = std::variant<Sustained, Transient, Vibration>;

}  // namespace scene

// Whether a decoder can read a patch with that encoder. The filter reads transient ones, too.
bool is_read(const scene::Encoder& encoder, bool by_filter);

}  // namespace afferent
