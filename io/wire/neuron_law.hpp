// What both ends of a session know of a patch's neurons.
#pragma once

namespace afferent {

// LifParameters of neurons/parameters.hpp, which has the equations and which the wire does not include.
struct NeuronLaw {
    double tau_m_ms = 10;
    double tau_g_ms = 100;
    double v_r_mv = -65;
    double v_th_mv = -50;
    double e_k_mv = -70;
    double delta_g = 0.06;
    double refractory_ms = 0;

    friend bool operator==(const NeuronLaw&, const NeuronLaw&) = default;
};

}  // namespace afferent
