// The neuron of a patch, and the form in which its neurons are computed. Included with scene.hpp by whoever
// builds a scene.
#pragma once

#include <cstdint>
#include <optional>

#include "afferent/neurons/parameters.hpp"
#include "afferent/scene/fields.hpp"

namespace afferent {

namespace scene {

// Forces are grip forces, of which an element feels its share.
struct Tuning {
    RateKind rate = RateKind::steady;
    double rate_hz = 100;
    double force_n = 20;
    double begin_force_n = 0.3;
    double slope_n_per_s = 100;
    double begin_slope_n_per_s = 5;
    std::optional<double> other_rate_hz = {};
    bool operator==(const Tuning&) const = default;
    static void fields(auto& self, auto&& f) {
        f("rate", self.rate);
        f(above("rate_hz", 0, 1e6), self.rate_hz);
        f(above("force_n", 0, 1e6), self.force_n);
        f(within("begin_force_n", 0, 1e6), self.begin_force_n);
        f(above("slope_n_per_s", 0, 1e9), self.slope_n_per_s);
        f(within("begin_slope_n_per_s", 0, 1e9), self.begin_slope_n_per_s);
        f(above("other_rate_hz", 0, 1e6), self.other_rate_hz);
    }
};

enum class Form { automatic, sparse, dense };

// The neuron as a digital chip computes it (neurons/fixed_point.hpp).
struct FixedPoint {
    std::uint32_t tick_us = 100;
    std::uint32_t state_bits = 16;
    std::uint32_t decay_bits = 16;
    Rounding rounding = Rounding::half_even;
    bool operator==(const FixedPoint&) const = default;
    static void fields(auto& self, auto&& f) {
        f(within("tick_us", 1, 10000), self.tick_us);
        f(within("state_bits", 4, 32), self.state_bits);
        f(within("decay_bits", 4, 24), self.decay_bits);
        f("rounding", self.rounding);
    }
};

struct Neuron : LifParameters {
    std::optional<FixedPoint> fixed_point = {};
    Tuning tuning = {};
    Form form = Form::automatic;
    double noise_mv = 0;
    bool operator==(const Neuron&) const = default;
    static void fields(auto& self, auto&& f) {
        f(within("tau_m_ms", 1e-6, 1e6), self.tau_m_ms);
        f(within("tau_g_ms", 1e-6, 1e6), self.tau_g_ms);
        f(within("v_r_mv", -1e6, 1e6), self.v_r_mv);
        f(within("v_th_mv", -1e6, 1e6), self.v_th_mv);
        f(within("e_k_mv", -1e6, 1e6), self.e_k_mv);
        f(within("delta_g", 0, 1e6), self.delta_g);
        f(within("refractory_ms", 0, 1e6), self.refractory_ms);
        f("fixed_point", self.fixed_point);
        f("tuning", self.tuning);
        f("form", self.form);
        f(within("noise_mv", 0, 1000), self.noise_mv);
    }
};

}  // namespace scene

// "neurons, by prediction"
const char* describe(scene::Form form);

}  // namespace afferent
