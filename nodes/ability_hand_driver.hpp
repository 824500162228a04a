// Drives an Ability Hand: which requests go over its line and when, what its replies are worth, and what it
// is commanded when they do not come.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "afferent/hand/ability_hand.hpp"
#include "afferent/nodes/hand_device.hpp"
#include "afferent/nodes/step_lateness.hpp"
#include "afferent/scene/hand.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// Pure: clock and line are its owner's. Everything that reaches the motors passes the interlock:
//
// - Before the first reply, and once the controller's last command is older than `safe`, requests only read:
// no
//   motor is commanded, and 300 ms after the last command the hand leaves its mode and stands.
// - Nothing closes while the last reply, or the controller's last command, is older than `freeze`. Opening is
// allowed
//   as long as the controller asks for it.
// - A command is within -1 and 1; one that is not a number is 0.
// - A flexor's target moves no faster than the scene's speed, for at most 20 ms at a time; stays between
// open_deg and
//   close_deg; and is never further from the finger than lead_deg.
//
// Allocates nothing after its first requests, but for notes.
class AbilityHandDriver {
  public:
    struct Parameters {
        scene::AbilityHand hand;
        // That each sensor reads at most. One whose reading is the highest that there is has this force.
        std::array<double, ability_hand::sensors> full_scale_n;
        Duration freeze;
        Duration safe;
    };
    AbilityHandDriver(const Parameters& parameters, MonotonicTime now);

    // The controller's last command.
    void follow(const DeviceCommand& command) noexcept { commanded_ = command; }

    // Bytes that have come over the line. `sample` takes the forces of each reply, in N.
    using Sample = std::function<void(MonotonicTime now, std::span<const double> forces_n)>;
    void read(MonotonicTime now, std::span<const std::byte> bytes, const Sample& sample);
    // The request to be written now, valid until the next call; empty if none is due.
    std::span<const std::byte> poll(MonotonicTime now);
    // When poll() has something to do, unless bytes come before.
    MonotonicTime wake() const noexcept;
    // The line has been opened again: nothing is under way.
    void begin_line() noexcept { asked_at_.reset(); }
    void lost_line() noexcept { ++readings_.lost_lines; }

    // Takes the readings of the next half second as those of untouched sensors, if they are steady and hide
    // at most zero_drift_n of what the scene's zero_counts would show.
    void take_zero(MonotonicTime now);
    // The readings taken last, or the scene's.
    const std::array<double, ability_hand::sensors>& zero_counts() const noexcept { return zero_counts_; }

    // What people should know, in order; nothing if that is all.
    std::optional<std::string> next_note();
    const HandReadings& readings(MonotonicTime now);

  private:
    // Readings of a stretch of time.
    struct Readings {
        MonotonicTime until{};
        std::uint32_t replies = 0;
        std::array<double, ability_hand::sensors> sum{};
    };
    struct Zero : Readings {
        std::array<std::uint16_t, ability_hand::sensors> lowest{};
        std::array<std::uint16_t, ability_hand::sensors> highest{};
    };

    bool plausible(const ability_hand::Reply& reply) const noexcept;
    void take(MonotonicTime now, const ability_hand::Reply& reply, const Sample& sample);
    void watch_sensors(MonotonicTime now, const ability_hand::Reply& reply);
    void watch_temperature(MonotonicTime now, unsigned status);
    // No untouched sensor reads more than a sensor has read: a zero that is stated too high comes down.
    void lower_zeros(MonotonicTime now, const ability_hand::Reply& reply);
    void add_to_zero(MonotonicTime now, const ability_hand::Reply& reply);
    void end_zero();
    bool is_driven(MonotonicTime now) const noexcept;
    double allowed(MonotonicTime now) const noexcept;
    ability_hand::Command command(MonotonicTime now);
    void move_targets(double command, MonotonicTime now, const scene::PositionDrive& drive);
    void watch_silence(MonotonicTime now);
    void count_latency(MonotonicTime now) noexcept;
    Duration patience() const noexcept;

    Parameters parameters_;
    Duration period_;
    ability_hand::FrameReader reader_;
    DeviceCommand commanded_;
    std::array<double, ability_hand::sensors> base_counts_{};  // the scene's
    std::array<double, ability_hand::sensors> zero_counts_{};
    std::array<double, ability_hand::sensors> forces_n_{};
    std::optional<Zero> zero_;
    Readings latest_;  // for zeros that are too high

    std::optional<MonotonicTime> replied_;  // the last plausible reply
    std::array<double, ability_hand::motors> position_deg_{};
    std::optional<std::array<double, ability_hand::motors>> target_deg_;
    MonotonicTime moved_at_{};  // the targets

    std::optional<MonotonicTime> asked_at_;  // the request that has not been answered
    ability_hand::Mode asked_mode_ = ability_hand::Mode::read_only;
    MonotonicTime next_request_;
    std::vector<std::byte> request_;

    // Arrivals of samples that no command is known to have been reached by; a ring, of which the oldest are
    // forgotten.
    std::array<MonotonicTime, 256> samples_{};
    std::size_t first_sample_ = 0;
    std::size_t sample_count_ = 0;
    StepLateness sample_to_command_;

    struct Watch {
        std::optional<MonotonicTime> since;
        bool told = false;
    };
    std::array<Watch, ability_hand::sensors> saturated_{};
    std::array<Watch, ability_hand::sensors> dead_{};
    MonotonicTime silent_since_;  // the last reply, or the beginning
    bool silence_told_ = false;
    unsigned told_status_ = 0;
    MonotonicTime status_told_at_{};
    std::deque<std::string> notes_;
    HandReadings readings_;
};

// Those of the plan's scene, which has an ability_hand.
AbilityHandDriver::Parameters ability_hand_driver_parameters(const Plan& plan);

// "thumb 1": the finger, and the sensor's place in the maker's list of that finger.
std::string ability_hand_sensor(std::size_t sensor);

}  // namespace afferent
