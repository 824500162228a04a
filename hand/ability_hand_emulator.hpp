// An emulated Ability Hand at its end of a serial line: motors, an object between the fingers, sensors, and
// what goes wrong with them and with the line. For tests, and for people who have no such hand.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "afferent/hand/ability_hand.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// The thumb presses against the four other fingers: half of the grip force is the thumb's, and an eighth each
// of the others'. Of a finger's force its sensors feel 30, 25, 20, 12, 8 and 5 %. A flexor is a servo with a
// spring:
//
//     dv/dt = (u − v) / 30 ms,  dθ/dt = v        u: what the mode asks for, less what the finger's force
//     takes F = its part of the stiffness · (0.7 mm/° · θ − distance)   where the finger touches, else 0
//
// 300 ms after the last command the hand leaves the mode that commands have set, and stands. Requests that
// only read are no commands.
class AbilityHandEmulator {
  public:
    // Probabilities that a reply is damaged; at most one of these happens to a reply.
    struct LineNoise {
        double lost_beginning = 0;  // the first bytes are missing
        double nulls = 0;           // zeros before it or within it
        double flipped_bit = 0;
        double half_frame = 0;  // the rest is missing
        double no_reply = 0;
    };

    struct Parameters {
        std::uint8_t address = 80;
        std::uint32_t baud = 921600;
        double stiffness_n_per_mm = 1.2;  // of the object, at all fingers together
        double distance_mm = 20;          // that a fingertip moves until it touches
        double breaking_n = 8;
        double noise_counts = 2;       // standard deviation of a reading
        double untouched_counts = 15;  // the mean; sensors differ by up to half of it
        LineNoise noise = {};
        std::uint64_t seed = 1;
    };
    explicit AbilityHandEmulator(const Parameters& parameters);

    // What tests and people may break while it runs.
    struct Faults {
        bool frozen = false;    // no request is read, and none is answered; the motors go on
        bool nonsense = false;  // random bytes in place of replies
        std::array<std::optional<std::uint16_t>, ability_hand::sensors> stuck_counts{};
        double pressing_n = 0;  // a force from outside on the sensors, without any closing
    };
    Faults& faults() noexcept { return faults_; }

    // Bytes that have reached the hand's end at that time. Times do not go back.
    void receive(TimePoint now, std::span<const std::byte> bytes);
    // When the last byte of the next reply will have gone over the line; nothing without one.
    std::optional<TimePoint> next_reply() const noexcept;
    // Appends the reply that is due at that time.
    void send(TimePoint now, std::vector<std::byte>& out);
    // Lets the fingers move until then.
    void advance(TimePoint now);

    double grip_n() const noexcept;
    double highest_grip_n() const noexcept { return highest_grip_n_; }
    bool broken() const noexcept { return highest_grip_n_ > parameters_.breaking_n; }
    double position_deg(std::size_t motor) const noexcept { return motors_[motor].position_deg; }
    // In a mode that requests have set.
    bool driven() const noexcept { return driven_; }
    std::uint64_t requests() const noexcept { return requests_; }
    std::uint64_t refused_frames() const noexcept { return reader_.refused(); }
    std::uint64_t damaged_replies() const noexcept { return damaged_; }

    // The share of the grip force that each sensor feels.
    static std::array<double, ability_hand::sensors> shares() noexcept;

  private:
    struct Motor {
        double position_deg = 0;
        double velocity_deg_per_s = 0;
    };

    void step(double seconds) noexcept;
    double finger_n(std::size_t finger) const noexcept;
    double asked_deg_per_s(std::size_t motor) const noexcept;
    ability_hand::Reply reply();
    void answer(TimePoint arrived);
    void damage();
    double random() noexcept;
    Duration byte_time(std::size_t bytes) const noexcept;

    Parameters parameters_;
    Faults faults_;
    ability_hand::FrameReader reader_;
    std::array<Motor, ability_hand::motors> motors_{};
    ability_hand::Command command_;
    bool driven_ = false;
    TimePoint now_ = scene_start;
    TimePoint heard_ = scene_start;
    TimePoint line_free_ = scene_start;
    std::optional<ability_hand::Request> asked_;  // to be answered
    std::vector<std::byte> reply_;
    TimePoint reply_at_{};
    double highest_grip_n_ = 0;
    std::uint64_t requests_ = 0;
    std::uint64_t damaged_ = 0;
    std::uint64_t readings_ = 0;
    std::uint64_t drawn_ = 0;
};

}  // namespace afferent
