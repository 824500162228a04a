// How well the sensors, the shares of their elements and the neurons are known.
#pragma once

namespace afferent {

// Standard deviations of what the builder of a hand does not know. Neither many afferents nor time average a
// systematic error away, so that the filter keeps it in its state or in sigma. The defaults are those of
// calibrated force-sensing elements.
struct Uncertainty {
    // Gain of each element, as a part of it; independent from element to element.
    double gain = 0.05;
    // Gain that all elements have in common, as a part of it: a supply, a temperature, a reference.
    double common_gain = 0.01;
    // Wandering of an element's share of the grip force about the one stated, as a part of it, and its
    // correlation time. The grip force is the sum over the elements: when one share shrinks, others grow.
    double share = 0.05;
    double share_time_s = 2;
    // Zero of an element, in N on the element.
    double offset_n = 0;
    // Hysteresis that is not modelled, as a part of the force.
    double hysteresis = 0.01;
    // The neurons' adaptation, as a part of it: tau_g and delta_g of a chip.
    double adaptation = 0;

    // Everything is as stated.
    static constexpr Uncertainty none() noexcept { return {0, 0, 0, 1, 0, 0, 0}; }

    friend bool operator==(const Uncertainty&, const Uncertainty&) = default;
};

}  // namespace afferent
