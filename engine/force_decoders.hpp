// The decoders of a controller: of the grip, and of its parts where the scene asks for them.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "afferent/decoders/grip_decoder.hpp"
#include "afferent/decoders/part_decoders.hpp"
#include "afferent/engine/controller_step.hpp"

namespace afferent {

// The calls are those of a decoder (decoder.hpp). Assigned to another of the same scene, it allocates
// nothing.
struct ForceDecoders {
    GripDecoder grip;
    std::optional<PartDecoders> parts;

    void observe(TimePoint begin, TimePoint end, std::span<const Event> events) {
        grip.observe(begin, end, events);
        if (parts) parts->observe(begin, end, events);
    }
    void lose(TimePoint begin, TimePoint end) {
        grip.lose(begin, end);
        if (parts) parts->lose(begin, end);
    }
    void presume_silence(TimePoint until) {
        grip.presume_silence(until);
        if (parts) parts->presume_silence(until);
    }
    TimePoint heard_until() const { return grip.heard_until(); }
    // Sets the estimates of the step.
    void estimate(TimePoint now, ControllerStep& step) {
        step.estimate = grip.estimate(now);
        for (std::size_t i = 0; i < step.parts.size(); ++i)
            step.parts[i] = {parts->estimate(i, now), std::nullopt};
    }
    void restart(TimePoint now) {
        grip.restart(now);
        if (parts) parts->restart(now);
    }
    // `last` is the grip's.
    void resume_after(TimePoint now, TimePoint heard_until, const Estimate& last) {
        grip.resume_after(now, heard_until, last);
        if (parts) parts->resume_after(now, heard_until, last);
    }
    void correct(const Estimate& last) {
        grip.correct(last);
        if (parts) parts->correct(last);
    }
    // The estimates that stand until something is known are those of the step.
    void correct(const ControllerStep& step) {
        grip.correct(step.estimate);
        for (std::size_t i = 0; i < step.parts.size(); ++i) parts->correct(i, step.parts[i].estimate);
    }
    std::size_t heap_bytes() const {
        return grip.bytes() - sizeof grip + (parts ? parts->bytes() - sizeof *parts : 0);
    }
};

}  // namespace afferent
