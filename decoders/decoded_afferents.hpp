// The description of the afferents whose events a decoder reads. Included by programs that decode without a
// scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "afferent/decoders/uncertainty.hpp"
#include "afferent/neurons/parameters.hpp"
#include "afferent/runtime/event.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// A neuron model from which a decoder computes the rate under a held drive, the drive for a rate, and the
// rheobase.
using DecodedNeuron = NeuronModel;

struct DecodedAfferents {
    // Afferents that fire alike under a grip force:
    //     sustained   drive = drive_mv_per_n · grip + bias_mv
    //     transient   drive = drive_mv_s_per_n · |d grip / dt| + bias_mv
    // Afferents without a share of the grip force have 0 for both.
    struct Group {
        DecodedNeuron neuron;
        double drive_mv_per_n;
        double bias_mv;
        double drive_mv_s_per_n = 0;
        // The grip force at which their elements are at full scale.
        double full_scale_n = std::numeric_limits<double>::infinity();
        // A sample of their elements measures the grip force F with the standard deviation noise_n +
        // noise_fraction · F.
        double noise_n = 0;
        double noise_fraction = 0;

        double rate_hz(RateKind kind, double grip_n) const;
        // The inverse of rate_hz(). Requires rate_hz > 0.
        double grip_n(RateKind kind, double rate_hz) const;
        // The grip force under which they have this drive.
        double grip_n(double drive_mv) const noexcept { return (drive_mv - bias_mv) / drive_mv_per_n; }
        // The grip force at which the resting neuron begins to fire; negative if the bias alone exceeds the
        // rheobase.
        double threshold_n() const;

        friend bool operator==(const Group&, const Group&) = default;
    };

    struct Afferent {
        Address address;
        std::uint32_t group;
        double share;  // of the grip force, >= 0
        // Afferents of one patch, such as a fingertip, touch and leave an object together.
        std::uint32_t patch = 0;

        friend bool operator==(const Afferent&, const Afferent&) = default;
    };

    std::size_t addresses = 0;  // in the stream, whether read or not
    std::vector<Group> groups{};
    std::vector<Afferent> afferents{};  // that are read, in increasing order of address
    double largest_grip_n = 0;          // that the sensors can measure
    Duration scan{};                    // the sampling period of the sensors, for which a drive is held
    // The longest time from the force on an element to the arrival of its sample.
    Duration delay{};
    // The sensors' hysteresis: loading reads low and unloading high by this part of the force.
    double hysteresis = 0;
    Duration tick = 1ns;  // event times are known to within as much
    Uncertainty uncertainty{};

    // Appends an afferent, and its group unless an equal one is there. The search is linear in the number of
    // groups; for thousands of different groups use AfferentBuilder.
    void add(Address address, const Group& group, double share, std::uint32_t patch = 0);

    // Element i is true if address i is read.
    std::vector<bool> read() const;

    // Throws ParameterError unless addresses are increasing and below `addresses`; each group exists; shares,
    // drives, biases and largest_grip_n finite, shares and largest_grip_n >= 0; full scales > 0; hysteresis
    // >= 0 and < 1; uncertainties finite and >= 0, uncertainty.share_time_s > 0.
    void check() const;

    friend bool operator==(const DecodedAfferents&, const DecodedAfferents&) = default;
};

}  // namespace afferent
