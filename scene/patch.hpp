// A patch of a scene with everything that the text left open filled in.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "afferent/encoders/calibration.hpp"
#include "afferent/encoders/sustained.hpp"
#include "afferent/encoders/transient.hpp"
#include "afferent/hand/sensor.hpp"
#include "afferent/neurons/parameters.hpp"
#include "afferent/neurons/tuning.hpp"
#include "afferent/proto/scene.pb.h"
#include "afferent/runtime/event.hpp"

namespace afferent {

struct Patch {
    std::string name;
    Address first;           // of its neurons
    std::uint32_t elements;  // as many as neurons

    // The patch whose elements the neurons read: this one, or the one named by elements_of.
    std::size_t reads;
    std::vector<double> share;  // of the grip force, one for each element

    // Of a patch with elements of its own.
    double rate_hz;
    Sensor::Parameters sensor;
    std::optional<Calibration> calibration;
    std::vector<std::uint32_t> dead;
    std::vector<std::pair<std::uint32_t, double>> stuck_n;
    bool refuse_out_of_range;

    std::variant<Sustained::Parameters, Transient::Parameters> encoder;
    NeuronParameters neuron;
    // How encoder and neuron were, or would be, tuned.
    TuningTarget target;

    bool owns_elements(std::size_t index) const noexcept { return reads == index; }
    bool sustained() const noexcept { return std::holds_alternative<Sustained::Parameters>(encoder); }
    double mean_share() const noexcept;
    // Drive for one newton (per second, where transient) on an element, and without any.
    double gain() const noexcept;
    double bias_mv() const noexcept;
};

}  // namespace afferent
