// The uncertainty of sensors, shares and neurons. Included by whoever builds a scene or describes afferents
// to a decoder.
#pragma once

namespace afferent {

// Standard deviations of systematic errors. They do not average out over afferents or time, so the filter
// carries them in its state or adds them to sigma. The defaults are typical of calibrated force-sensing
// elements.
struct Uncertainty {
    // Relative error of the gain of each element, independent between elements.
    double gain = 0.05;
    // Relative error of the gain that all elements have in common, as by supply voltage, temperature or
    // reference.
    double common_gain = 0.01;
    // Relative deviation of an element's share of the grip force from the stated one, which varies with the
    // given correlation time. As the grip force is the sum over the elements, one share shrinks as others
    // grow.
    double share = 0.05;
    double share_time_s = 2;
    // Error of the zero of each element, in N on the element.
    double offset_n = 0;
    // Hysteresis beyond the modelled one, relative to the force.
    double hysteresis = 0.01;
    // Relative error of the neurons' adaptation: tau_g and delta_g of a chip.
    double adaptation = 0;

    // Everything is exactly as stated.
    static constexpr Uncertainty none() noexcept { return {0, 0, 0, 1, 0, 0, 0}; }

    friend bool operator==(const Uncertainty&, const Uncertainty&) = default;
};

}  // namespace afferent
