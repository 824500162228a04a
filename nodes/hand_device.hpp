// A hand that can be touched, on a line of its own: commands go to it, and the samples of its sensors come
// from it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "afferent/nodes/hand_report.hpp"
#include "afferent/runtime/monotonic_time.hpp"

namespace afferent {

// What the hand's motors are to do, as of the controller's last step.
struct DeviceCommand {
    double command = 0;           // -1 (open) to 1 (close)
    MonotonicTime at{};           // of the step
    MonotonicTime known_until{};  // the events before this time are in the step's estimate
};

// The forces of all of the scene's elements, in N, when they arrived.
struct HandScan {
    MonotonicTime at{};
    std::vector<double> forces_n = {};
};

// Has a thread of its own, from start() to its destruction. What it keeps for others is bounded: when nobody
// takes it, the newest is dropped.
class HandDevice {
  public:
    virtual ~HandDevice() = default;

    // To be called once. `arrived` is called on the device's thread whenever a scan or a note waits; it
    // neither waits nor throws.
    virtual void start(std::function<void()> arrived) = 0;
    // By the thread that steps the hand. Neither waits, allocates nor throws.
    virtual void command(const DeviceCommand& command) noexcept = 0;

    // By the one thread that takes them; a scan is valid until the next call.
    virtual const HandScan* next_scan() = 0;
    virtual std::optional<std::string> next_note() = 0;  // what people should know
    virtual const HandReadings& readings() = 0;
    virtual std::uint64_t dropped_scans() const noexcept = 0;

    // By any thread: the readings of the next half second are those of untouched sensors. Refused, with a
    // note, if they cannot be.
    virtual void take_zero() noexcept = 0;
};

}  // namespace afferent
