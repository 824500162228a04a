// The encoder of a patch, from force to drive. Included with scene.hpp by whoever builds a scene.
#pragma once

#include <optional>
#include <variant>

#include "afferent/scene/fields.hpp"

namespace afferent {

namespace scene {

// If absent, gain and bias are computed from the neuron's tuning.
struct Sustained {
    static constexpr const char* alternative = "sustained";
    std::optional<double> gain_mv_per_n = {};
    std::optional<double> bias_mv = {};
    bool operator==(const Sustained&) const = default;
    static void fields(auto& self, auto&& f) {
        f(above("gain_mv_per_n", 0, 1e12), self.gain_mv_per_n);
        f(within("bias_mv", -1e12, 1e12), self.bias_mv);
    }
};

struct Transient {
    static constexpr const char* alternative = "transient";
    std::optional<double> gain_mv_s_per_n = {};
    std::optional<double> bias_mv = {};
    std::optional<double> corner_hz = {};
    bool operator==(const Transient&) const = default;
    static void fields(auto& self, auto&& f) {
        f(above("gain_mv_s_per_n", 0, 1e12), self.gain_mv_s_per_n);
        f(within("bias_mv", -1e12, 1e12), self.bias_mv);
        f(within("corner_hz", 0.1, 1e5), self.corner_hz);
    }
};

// The gain is required: it does not follow from a tuning.
struct Vibration {
    static constexpr const char* alternative = "vibration";
    std::optional<double> gain_mv_s2_per_n = {};
    std::optional<double> bias_mv = {};
    double corner_hz = 250;
    bool operator==(const Vibration&) const = default;
    static void fields(auto& self, auto&& f) {
        f(above("gain_mv_s2_per_n", 0, 1e12), self.gain_mv_s2_per_n);
        f(within("bias_mv", -1e12, 1e12), self.bias_mv);
        f(within("corner_hz", 0.1, 1e5), self.corner_hz);
    }
};

using Encoder = std::variant<Sustained, Transient, Vibration>;

}  // namespace scene

// Whether a decoder can read a patch with that encoder. The filter reads transient ones, too.
bool is_read(const scene::Encoder& encoder, bool by_filter);

}  // namespace afferent
