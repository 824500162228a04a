// The serial protocol of the Psyonic Ability Hand: frames, commands, replies and the law of its force
// sensors, as its maker documents them (ability-hand-api, python wrapper 2025). Motors and fingers are in the
// order index, middle, ring, little finger, thumb's flexor, thumb's rotator.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "afferent/runtime/time.hpp"

namespace afferent::ability_hand {

inline constexpr std::size_t motors = 6;
inline constexpr std::size_t flexors = 5;  // the first of the motors
inline constexpr std::size_t sensors_per_finger = 6;
inline constexpr std::size_t sensors = flexors * sensors_per_finger;
inline constexpr std::uint16_t most_counts = 4095;
// The hand leaves a mode, and stands, so long after the last command.
inline constexpr Duration leaves_mode_after = 300ms;

// What a command's values are: degrees, degrees per second, amperes, percent of the full duty cycle.
// `read_only` has none, and moves nothing.
enum class Mode : std::uint8_t {
    position = 0x10,
    velocity = 0x20,
    current = 0x30,
    duty = 0x40,
    read_only = 0xa0
};

// What a reply has beside positions and status.
enum class Variant : std::uint8_t {
    current_and_sensors = 0,
    velocity_and_sensors = 1,
    current_and_velocity = 2
};

struct Command {
    Mode mode = Mode::read_only;
    std::array<double, motors> values{};
    bool operator==(const Command&) const = default;
};

struct Request {
    Command command;
    Variant variant = Variant::current_and_sensors;
};

struct Reply {
    Mode mode = Mode::read_only;  // of the command that it answers
    Variant variant = Variant::current_and_sensors;
    std::array<double, motors> position_deg{};
    std::array<double, motors> current_a{};           // unless the variant has none: 0
    std::array<double, motors> velocity_deg_per_s{};  // of the rotors; unless the variant has none: 0
    std::array<std::uint16_t, sensors> counts{};      // six of each finger; unless the variant has none: 0
    std::uint8_t status = 0;                          // 0: neither hot nor cold
};

// Force by a sensor's reading; at 0 counts the limit of the law, which is not 0. Rises with the counts.
double force_n(double counts) noexcept;
// The reading at that force: the inverse, not rounded, from 0 to most_counts.
double counts_at(double force_n) noexcept;

// A payload with its checksum, stuffed, between two flags.
void append_frame(std::span<const std::byte> payload, std::vector<std::byte>& out);
// Values beyond the range of the wire are clipped to it; one that is not a number is 0.
void append_request(std::uint8_t address, const Request& request, std::vector<std::byte>& out);
void append_reply(const Reply& reply, std::vector<std::byte>& out);

// What a payload says, without its checksum. Nothing if it is no reply, or no request to this address.
std::optional<Reply> read_reply(std::span<const std::byte> payload);
std::optional<Request> read_request(std::uint8_t address, std::span<const std::byte> payload);

// Finds frames on a line that may be cut or disturbed anywhere: a flag ends whatever came before it. A single
// bit that is flipped, a byte that is lost or added, and a frame that is cut are noticed; of other damage
// that keeps a frame's length, one in 256 passes the checksum. Allocates nothing.
class FrameReader {
  public:
    // Passes on the payloads that end in these bytes, without their checksums, each valid until the sink
    // returns.
    template <class Sink>
    void read(std::span<const std::byte> bytes, const Sink& sink) {
        for (const std::byte byte : bytes)
            if (const auto payload = add(byte); !payload.empty()) sink(payload);
    }
    // How often the bytes between two flags were no frame. Nulls between frames are not counted: a line
    // driver that turns around makes them.
    std::uint64_t refused() const noexcept { return refused_; }

  private:
    static constexpr std::size_t longest = 96;  // of a payload with its checksum

    std::span<const std::byte> add(std::byte byte) noexcept;
    std::span<const std::byte> end_frame() noexcept;

    std::array<std::byte, longest> bytes_{};
    std::size_t size_ = 0;
    bool escaped_ = false;
    bool bad_ = false;  // too long, or an escape before a flag
    std::uint64_t refused_ = 0;
};

}  // namespace afferent::ability_hand
