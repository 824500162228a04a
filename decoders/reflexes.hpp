// What a hand does of its own accord, without being asked by the EMG. Included by whoever builds a scene.
#pragma once

#include <optional>

#include "afferent/decoders/contact_reflex.hpp"
#include "afferent/decoders/emg_control.hpp"
#include "afferent/decoders/slip_pulse.hpp"

namespace afferent {

// The brake at a contact, and the closing pulse at a slip; without either the command is that of gain and
// EMG.
class Reflexes {
  public:
    struct Parameters {
        std::optional<ContactReflex::Parameters> brake = {};
        std::optional<SlipPulse::Parameters> pulse = {};
        bool operator==(const Parameters&) const = default;
    };

    // Throws ParameterError as the two do.
    explicit Reflexes(const Parameters& parameters) {
        if (parameters.brake) brake_.emplace(*parameters.brake);
        if (parameters.pulse) pulse_.emplace(*parameters.pulse);
    }

    // The command of the motor from now until the next call. Times do not decrease. `heard` as for SlipPulse.
    double operator()(TimePoint now, const Estimate& estimate, bool heard, GripState grip,
                      const GripCommand& given) noexcept {
        double command = given.command;
        if (brake_) command = (*brake_)(now, estimate.force_n, grip, command);
        if (pulse_) command = (*pulse_)(now, estimate, heard, grip, given.gain, command);
        return command;
    }

    // As at the first call.
    void restart() noexcept {
        if (brake_) brake_->restart();
        if (pulse_) pulse_->restart();
    }

  private:
    std::optional<ContactReflex> brake_;
    std::optional<SlipPulse> pulse_;
};

}  // namespace afferent
