// How well the sensors, the shares of their elements and the neurons are known.
#pragma once

namespace afferent {

// What the builder of a hand does not know, as standard deviations. A systematic error is neither averaged
// away by many afferents nor by time, so that the filter keeps it in its state or in sigma. The defaults are
// those of calibrated force-sensing elements.
struct Uncertainty {
    // Of one element's gain, as a part of it; independent from element to element.
    double gain = 0.05;
    // Of a gain that all elements have in common, as a part of it: a supply, a temperature, a reference.
    double common_gain = 0.01;
    // How far an element's share of the grip force wanders from the one stated, as a part of it, and how long
    // it takes. What one element loses others gain: the grip force is what the elements feel in all.
    double share = 0.05;
    double share_time_s = 2;
    // Of an element's zero, in N on the element.
    double offset_n = 0;
    // Hysteresis that is not modelled, as a part of the force.
    double hysteresis = 0.01;
    // Of the neurons' constants, as a part of their adaptation: tau_g and delta_g of a chip.
    double adaptation = 0;

    // Everything is as stated.
    static constexpr Uncertainty none() noexcept { return {0, 0, 0, 1, 0, 0, 0}; }

    friend bool operator==(const Uncertainty&, const Uncertainty&) = default;
};

}  // namespace afferent
