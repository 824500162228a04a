// What a controller is made of.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "afferent/decoders/emg_control.hpp"
#include "afferent/decoders/gain_reach.hpp"
#include "afferent/decoders/grip_decoder.hpp"
#include "afferent/decoders/part_decoders.hpp"
#include "afferent/decoders/readouts.hpp"
#include "afferent/decoders/reflexes.hpp"
#include "afferent/hand/emg_envelope.hpp"
#include "afferent/scene/plan_items.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// Elements that have an estimate of their own: first_element, first_element + 1, ... among all of the scene.
struct PartPlan {
    std::string name;  // of columns: letters, digits and underscores
    std::size_t patch;
    Address first_element;
    std::uint32_t elements;
    PartDecoders::Part decoded;
};

struct ReadoutPlans {
    std::vector<ReadoutParameters> parameters;
    std::vector<PlanItem> items;  // of each patch, where the scene asks for them
};

struct ControllerPlan {
    DecoderParameters decoder;
    DecodedAfferents afferents;
    std::vector<PartPlan> parts;  // none: the grip alone is estimated
    ReadoutPlans readouts;
    EmgControl::Parameters control;
    Reflexes::Parameters reflexes;
    // A span whose packet would have been delivered by now counts as silent, or as foreseen where
    // link.timing_tolerance_us is: while the link delivers in time.
    bool presumes;
    double emg_rate_hz;
    // For both electrodes. Where a table of EMG does not say its counts at rest, they are its median, and are
    // not known here.
    EmgEnvelope::Parameters closing;
    EmgEnvelope::Parameters opening;

    GainLoop gain_loop() const noexcept { return {decoder, afferents, control.gain}; }
};

Reflexes::Parameters reflex_parameters(const Scene& scene);
DecoderParameters decoder_parameters(const Scene& scene);

}  // namespace afferent
