// The result of one presentation of an object.
#pragma once

#include <cstdint>
#include <optional>

#include "afferent/studies/trial/outcome.hpp"

namespace afferent {

// Times count from the beginning of the presentation.
struct Presentation {
    // The same number: the same object, intent and noise, whatever the condition.
    std::uint32_t number = 0;
    Outcome outcome = Outcome::dropped;
    // The heavy object that slips. It does not break.
    bool slippery = false;
    std::optional<double> breaking_force_n = {};
    double stiffness_n_per_mm = 0;
    double weight_n = 0;
    double aimed_force_n = 0;
    double peak_force_n = 0;
    double held_force_n = 0;  // at the end
    std::optional<double> contact_s = {};
    // From the contact until the hand is told of it: its estimate, or the rate of the spikes, is above the
    // highest before the contact. Absent where that does not happen.
    std::optional<double> told_s = {};
    // From the contact until the command is lower than what the EMG asks for at the gain before the contact.
    // Absent where that does not happen, as without feedback.
    std::optional<double> answer_s = {};
    std::optional<double> broken_s = {};
    std::optional<double> dropped_s = {};
    std::optional<double> slip_onset_s = {};
    // From the onset until a pulse closes the hand, or the gain is above the highest of the 100 ms before the
    // onset by 0.01. Absent where neither happens, as without feedback.
    std::optional<double> slip_reaction_s = {};
    double slipped_mm = 0;
    // Closing pulses that the hand began before anything slipped.
    std::uint32_t false_pulses = 0;
    // The link was silent for too long.
    bool safe_state = false;

    friend bool operator==(const Presentation&, const Presentation&) = default;
};

// One step of a presentation, for pictures.
struct TraceStep {
    double time_s;
    double force_n;
    double estimate_n;
    double gain;
    double closing;  // effort, as the electrode's envelope has it
    double command;
};

}  // namespace afferent
