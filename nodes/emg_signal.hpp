// Recorded EMG as the counts that a controller's electrode reads: around rest, with the strongest contraction
// at full scale.
#pragma once

#include <string>

#include "afferent/io/files/table.hpp"
#include "afferent/nodes/emg.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// What the recording is taken for and how it was scaled, for people; empty: it was not.
struct EmgReading {
    EmgTable table;
    std::string said;
};

// Counts stay as they are: of columns that are called so; and, where their name has no unit, those of whole
// numbers that are not negative, those with numbers beyond 10, and all where the scene says counts at rest.
// Volts lose their median; where they are raw, they are band-passed from 20 to 450 Hz, or to 0.45 of their
// rate where that is less: below lie movements of the electrodes, above only noise (De Luca, Gilmore,
// Kuznetsov and Roy 2010, J. Biomech. 43:1573). The controller rectifies and smooths what comes of it
// (hand/emg_envelope.hpp), as it does with counts. An envelope loses its lower twentieth, its level at rest.
// Either is scaled so that the envelope that is exceeded 1 % of the time, or full_scale_v, becomes
// full_scale_counts.
//
// `table` has the one column of EMG. `asked` says unit, signal and scale, and `envelope_ms` how the
// controller smooths.
EmgReading read_emg(Table table, const scene::EmgTable& asked, double envelope_ms);

}  // namespace afferent
