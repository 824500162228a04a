// The parameters of the leaky integrate-and-fire neurons, with and without adaptation.
#pragma once

#include <string>

#include "afferent/runtime/time.hpp"

namespace afferent {

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

    // Throws ParameterError: tau_m_ms > 0, tau_g_ms > 0, v_r < v_th, E_k < v_th, delta_g >= 0, refractory_ms
    // >= 0, all finite.
    void check() const;

    // What every model in the list of neurons/models.hpp tells of itself.
    static constexpr const char* name = "lif";
    double adaptation() const noexcept { return delta_g; }
    LifParameters with_adaptation(double new_delta_g) const noexcept;
    Milliseconds refractory() const noexcept { return Milliseconds(refractory_ms); }
    std::string describe() const;

    friend bool operator==(const LifParameters&, const LifParameters&) = default;
};

}  // namespace afferent
