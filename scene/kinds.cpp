// The numbers of the kinds, and where they come from.
//
// Density, per cm² of the fingertip: Johansson and Vallbo (1979), J Physiol 286:283; Saal et al. (2017), PNAS
// 114:E5693. Half of the lattice's spacing for the jitter is an assumption.
//
// Receptive fields of SA1 and RA: the normal stress below a point load on an elastic half-space (Boussinesq)
// falls to one half as far from its axis as a Gaussian with a standard deviation of 0.48 of the depth does.
// Merkel cells and Meissner corpuscles lie some 1 mm deep in the fingertip: Johnson (2001), Curr Opin
// Neurobiol 11:455, on how fine their fields are. PC: fields of 101 mm² at 4 to 5 times the threshold, which
// a Gaussian passes at 1.73 standard deviations: Johansson and Vallbo (1980), Brain Res 184:353.
//
// Corner frequencies: the best frequencies of RA, 40 to 60 Hz, and PC, 200 to 300 Hz: Freeman and Johnson
// (1982), J Physiol 323:43; Bolanowski et al. (1988), J Acoust Soc Am 84:1680. A neuron that integrates
// prefers slow vibration a little, so that the corners lie above the best frequencies, 45 and 250 Hz.
//
// Gain, negative ratio, time constants, delta_g and refractory period: fitted to the rates and first spikes
// of a ramp and a sine in Saal et al. (2017), with indentation as pressure by a flat punch on a half-space of
// 50 kPa and Poisson's ratio 0.4, and, RA and PC, to one spike a cycle over a factor of 2 of amplitudes that
// begins at some twice the threshold, at 20, 40 and 60 Hz and at 100, 250 and 400 Hz: Talbot et al. (1968), J
// Neurophysiol 31:301; Freeman and Johnson (1982). docs/afferents.md has what the fit reaches. Those of
// SA1_DYNAMIC besides to the steady rates of SA1. v_r, v_th and E_K are the defaults of LifParameters.
//
// Spread of gain: velocity thresholds of 39 RA units range from 0.4 to 39.3 mm/s, and of 10 PC units from 0.5
// to 19.6: Knibestöl (1973), J Physiol 232:427. The range of so many normal numbers is 4.3 and 3.1 standard
// deviations. That of SA1, half as much, is an assumption. Phases are as even as they can be.
#include "afferent/scene/patch.hpp"

namespace afferent::scene {
namespace {

Spread spread(double gain_sigma) {
    return {.gain = LogNormal{.median = 1, .sigma = gain_sigma}, .phase = Uniform{.lowest = 0, .highest = 1}};
}

Neuron neuron(double tau_m_ms, double tau_g_ms, double delta_g, double refractory_ms) {
    Neuron neuron;
    neuron.tau_m_ms = tau_m_ms;
    neuron.tau_g_ms = tau_g_ms;
    neuron.delta_g = delta_g;
    neuron.refractory_ms = refractory_ms;
    return neuron;
}

}  // namespace

const char* name(Kind kind) {
    switch (kind) {
        case Kind::sa1:
        case Kind::sa1_dynamic:
            return "SA1";
        case Kind::ra:
            return "RA";
        case Kind::pc:
            return "PC";
    }
    return "";
}

Patch preset(Kind kind) {
    Patch patch;
    patch.of_kind = kind;
    switch (kind) {
        case Kind::sa1:
            patch.afferents = Afferents{.per_cm2 = 70, .jitter = 0.5, .field_sd_mm = 0.5};
            patch.encoder = Sustained{.gain_mv_per_n = 12'000};
            patch.neuron = neuron(5, 440, 2.1, 1.8);
            patch.spread = spread(0.5);
            break;
        case Kind::sa1_dynamic:
            patch = preset(Kind::sa1);
            patch.of_kind = kind;
            patch.encoder =
                Sustained{.gain_mv_per_n = 4270, .dynamic = Dynamic{.time_ms = 170, .corner_hz = 72}};
            patch.neuron = neuron(60, 122, 2.6, 0.5);
            break;
        case Kind::ra:
            patch.afferents = Afferents{.per_cm2 = 140, .jitter = 0.5, .field_sd_mm = 0.5};
            patch.encoder = Transient{.gain_mv_s_per_n = 360, .corner_hz = 46, .negative_ratio = 0.12};
            patch.neuron = neuron(34, 6, 9, 1.8);
            patch.spread = spread(1.07);
            break;
        case Kind::pc:
            patch.afferents = Afferents{.per_cm2 = 25, .jitter = 0.5, .field_sd_mm = 3.27};
            patch.encoder = Vibration{.gain_mv_s2_per_n = 205, .corner_hz = 290, .negative_ratio = 0};
            patch.neuron = neuron(0.8, 3.5, 2.2, 2.2);
            patch.spread = spread(1.19);
            break;
    }
    return patch;
}

}  // namespace afferent::scene
