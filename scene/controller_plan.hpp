// What a controller is made of.
#pragma once

#include <optional>
#include <vector>

#include "afferent/decoders/decoders.hpp"
#include "afferent/decoders/outputs.hpp"
#include "afferent/hand/emg_envelope.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

struct ControllerPlan {
    DecoderParameters decoder;
    DecodedAfferents afferents;
    OutputParameters output;
    double emg_rate_hz;
    // For both electrodes. Where a table of EMG does not say its counts at rest, they are its median, and are
    // not known here.
    EmgEnvelope::Parameters closing;
    EmgEnvelope::Parameters opening;
};

}  // namespace afferent
