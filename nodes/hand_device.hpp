// A hand that can be touched: commands go to it, and the samples of its sensors come from it. Included by
// programs that bring a hand of their own.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "afferent/runtime/monotonic_time.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// What the hand's motors are to do, as of the controller's last step.
struct DeviceCommand {
    double command = 0;           // -1 (open) to 1 (close)
    MonotonicTime at{};           // of the step
    MonotonicTime known_until{};  // the events before this time are in the step's estimate
};

// The forces of all of the scene's elements, in N, when they arrived. One with another number of forces, with
// a force that is negative or not finite, or of a time to come is not used: the grip then goes safe without
// samples.
struct HandScan {
    MonotonicTime at{};
    std::vector<double> forces_n = {};
};

// What a hand on a line of its own says of itself, and what has gone over that line.
struct HandReadings {
    struct Motor {
        const char* name = "";
        double position_deg = 0;
        double current_a = 0;
    };
    std::array<Motor, 8> motors{};
    std::size_t motor_count = 0;
    std::array<double, 32> zero_counts{};  // of the sensors, as they are taken to be now
    std::size_t sensor_count = 0;
    unsigned temperature_status = 0;  // 0: neither hot nor cold
    bool answering = false;           // a reply has come within freeze_ms
    bool driven = false;              // it is commanded, and not only asked for its readings
    std::uint64_t commands = 0;
    std::uint64_t replies = 0;
    std::uint64_t unanswered = 0;
    std::uint64_t refused_frames = 0;
    std::uint64_t implausible_replies = 0;  // whole, and not what this hand could say
    std::uint64_t lost_lines = 0;           // how often the line has failed
    std::uint64_t zeros_taken = 0;
    std::uint64_t zeros_refused = 0;
    // From the arrival of a sample to the first command that it is known to have reached.
    Duration sample_to_command_p50{};
    Duration sample_to_command_p99{};
    Duration sample_to_command_max{};
};

// May have a thread of its own, from start() to its destruction. What it keeps for others is bounded: when
// nobody takes it, the newest is dropped.
class HandDevice {
  public:
    virtual ~HandDevice() = default;

    // To be called once. `arrived` is called whenever a scan or a note waits; it neither waits nor throws.
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
