// The parameters of the neurons. Included by whoever builds a scene, or describes afferents to a decoder.
#pragma once

#include <cstdint>
#include <string>
#include <variant>

#include "afferent/runtime/time.hpp"

namespace afferent {

// The two rates of an adapting neuron under a held drive.
enum class RateKind {
    steady,  // after adaptation
    onset,   // the reciprocal of the first interspike interval after a step from rest
};

//     tau_m dv/dt = v_r − v + R·I − g (v − E_k)        tau_g dg/dt = −g
//     v reaches v_th:  v := v_r,  g := g + Δg
//
// g is dimensionless: conductance times membrane resistance. After a spike v stays at v_r for the refractory
// period while g decays. The defaults are the textbook values of Dayan and Abbott, Theoretical Neuroscience
// (2001), fig. 5.14, with the membrane of a fast afferent.
struct LifParameters {
    double tau_m_ms = 10;
    double tau_g_ms = 100;
    double v_r_mv = -65;
    double v_th_mv = -50;
    double e_k_mv = -70;
    double delta_g = 0.06;
    double refractory_ms = 0;

    // The drive R·I at and below which the resting neuron never fires.
    double rheobase_mv() const noexcept { return v_th_mv - v_r_mv; }

    // Throws ParameterError unless tau_m_ms > 0, tau_g_ms > 0, v_r < v_th, E_k < v_th, delta_g >= 0 and
    // refractory_ms >= 0, all finite.
    void check() const;

    // Every model in the list of neurons/models.hpp has these.
    static constexpr const char* name = "lif";
    double adaptation() const noexcept { return delta_g; }
    LifParameters with_adaptation(double new_delta_g) const noexcept;
    Milliseconds refractory() const noexcept { return Milliseconds(refractory_ms); }
    std::string describe() const;

    friend bool operator==(const LifParameters&, const LifParameters&) = default;
};

// Rounding of a product to the bits that are kept.
enum class Rounding : std::uint8_t {
    half_even,   // to the nearest integer, ties to even
    truncation,  // an arithmetic shift alone: towards minus infinity
};

// Three scalings follow from the parameters:
//     v  state_bits, of which seven eighths span
//        from the lower of v_r and E_k up to v_th,
//        and the last eighth lies above it
//     g  state_bits without sign, up to what spikes every 4 ms for good lead to, Δg/(1 − e^(−4 ms/tau_g)), or
//        every refractory period if that is longer
//     drive  five bits more than v, signed, in v's unit
struct FixedPointParameters {
    LifParameters lif = {};
    std::uint32_t tick_us = 100;    // 1 to 10,000
    std::uint32_t state_bits = 16;  // 4 to 32
    std::uint32_t decay_bits = 16;  // 4 to 24; the width of every multiplier
    Rounding rounding = Rounding::half_even;

    // Throws ParameterError if the LIF parameters are invalid; a width or the tick is out of range; v_r and
    // v_th, or 0 and Δg, are equal in the resolution of the state; or a decay factor rounds to 1 in the width
    // of the multiplier.
    void check() const;

    static constexpr const char* name = "fixed_point";
    double adaptation() const noexcept { return lif.delta_g; }
    FixedPointParameters with_adaptation(double delta_g) const noexcept;
    Milliseconds refractory() const noexcept { return lif.refractory(); }
    std::string describe() const;

    friend bool operator==(const FixedPointParameters&, const FixedPointParameters&) = default;
};

// The closed list of neuron models. models.hpp has the requirements of each; the first is the default.
using NeuronModel = std::variant<LifParameters, FixedPointParameters>;

}  // namespace afferent
