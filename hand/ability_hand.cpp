#include "afferent/hand/ability_hand.hpp"

#include <algorithm>
#include <cmath>

namespace afferent::ability_hand {
namespace {

constexpr std::byte flag{0x7e};
constexpr std::byte escape{0x7d};
constexpr std::byte escape_mask{0x20};

constexpr double wire_limit = 32767;

// Counts of the wire for each unit.
constexpr double per_degree = wire_limit / 150;
constexpr double per_degree_per_s = wire_limit / 3000;
constexpr double per_rotor_degree_per_s = 4 * wire_limit / 3000;
constexpr double per_ampere = 620.606079;
constexpr double per_percent = 3546.0 / 100;

// A force-sensing resistor below a fixed one, read at 3.3 V.
constexpr double volts_per_count = 3.3 / 4096;
constexpr double series_ohm_volts = 33000;
constexpr double offset_ohm = 10000;
constexpr double force_numerator = 121591;
constexpr double force_offset_n = 0.878894;

double per_unit(Mode mode) {
    switch (mode) {
        case Mode::position:
            return per_degree;
        case Mode::velocity:
            return per_degree_per_s;
        case Mode::current:
            return per_ampere;
        case Mode::duty:
            return per_percent;
        case Mode::read_only:
            break;
    }
    return 0;
}

std::int16_t on_wire(double value, double per_unit) {
    if (std::isnan(value)) return 0;
    return static_cast<std::int16_t>(std::lround(std::clamp(value * per_unit, -wire_limit, wire_limit)));
}

// A payload that is being written.
class Payload {
  public:
    void add(unsigned byte) noexcept { bytes_[size_++] = static_cast<std::byte>(byte); }
    void add(std::int16_t value) noexcept {
        const unsigned bits = static_cast<std::uint16_t>(value);
        add(bits & 0xff);
        add(bits >> 8);
    }
    std::span<const std::byte> bytes() const noexcept { return std::span(bytes_).first(size_); }

  private:
    std::array<std::byte, 80> bytes_{};
    std::size_t size_ = 0;
};

// Takes values off the beginning of a payload that has been found long enough.
class Cursor {
  public:
    explicit Cursor(std::span<const std::byte> bytes) : rest_(bytes) {}

    std::uint8_t byte() {
        const auto value = std::to_integer<std::uint8_t>(rest_.front());
        rest_ = rest_.subspan(1);
        return value;
    }
    double number(double per_unit) {
        const unsigned low = byte();
        return static_cast<std::int16_t>(low | unsigned{byte()} << 8) / per_unit;
    }
    // Two readings of twelve bits in three bytes, the lower bits first.
    void pair(std::uint16_t& first, std::uint16_t& second) {
        const unsigned low = byte();
        const unsigned middle = byte();
        const unsigned high = byte();
        first = static_cast<std::uint16_t>(low | (middle & 0xf) << 8);
        second = static_cast<std::uint16_t>(middle >> 4 | high << 4);
    }

  private:
    std::span<const std::byte> rest_;
};

constexpr std::size_t size_with_sensors = 1 + motors * 4 + sensors / 2 * 3 + 1;
constexpr std::size_t size_without_sensors = 1 + motors * 6 + 1;
static_assert(size_with_sensors == 71 && size_without_sensors == 38);

std::optional<Mode> mode_of(unsigned header) {
    for (const Mode mode : {Mode::position, Mode::velocity, Mode::current, Mode::duty, Mode::read_only})
        if ((header & 0xf0) == static_cast<unsigned>(mode) && (header & 0xf) <= 2) return mode;
    return std::nullopt;
}

unsigned header_of(Mode mode, Variant variant) {
    return static_cast<unsigned>(mode) | static_cast<unsigned>(variant);
}

unsigned sum(std::span<const std::byte> bytes) {
    unsigned sum = 0;
    for (const std::byte byte : bytes) sum += std::to_integer<unsigned>(byte);
    return sum;
}

}  // namespace

double force_n(double counts) noexcept {
    const double volts = std::clamp<double>(counts, 0, most_counts) * volts_per_count;
    return force_numerator * volts / (series_ohm_volts + offset_ohm * volts) + force_offset_n;
}

double counts_at(double force_n) noexcept {
    const double above = std::max(0.0, force_n - force_offset_n);
    const double left = force_numerator - above * offset_ohm;
    if (!(left > 0)) return most_counts;
    return std::min<double>(above * series_ohm_volts / left / volts_per_count, most_counts);
}

void append_frame(std::span<const std::byte> payload, std::vector<std::byte>& out) {
    const auto stuff = [&out](std::byte byte) {
        if (byte == flag || byte == escape) {
            out.push_back(escape);
            byte ^= escape_mask;
        }
        out.push_back(byte);
    };
    out.push_back(flag);
    std::for_each(payload.begin(), payload.end(), stuff);
    stuff(static_cast<std::byte>(-sum(payload) & 0xff));
    out.push_back(flag);
}

void append_request(std::uint8_t address, const Request& request, std::vector<std::byte>& out) {
    const Mode mode = request.command.mode;
    Payload payload;
    payload.add(unsigned{address});
    payload.add(header_of(mode, request.variant));
    if (mode != Mode::read_only)
        for (const double value : request.command.values) payload.add(on_wire(value, per_unit(mode)));
    append_frame(payload.bytes(), out);
}

void append_reply(const Reply& reply, std::vector<std::byte>& out) {
    Payload payload;
    payload.add(header_of(reply.mode, reply.variant));
    for (std::size_t i = 0; i < motors; ++i) {
        payload.add(on_wire(reply.position_deg[i], per_degree));
        payload.add(reply.variant == Variant::velocity_and_sensors
                        ? on_wire(reply.velocity_deg_per_s[i], per_rotor_degree_per_s)
                        : on_wire(reply.current_a[i], per_ampere));
    }
    if (reply.variant == Variant::current_and_velocity) {
        for (const double velocity : reply.velocity_deg_per_s)
            payload.add(on_wire(velocity, per_rotor_degree_per_s));
    } else {
        for (std::size_t i = 0; i < sensors; i += 2) {
            const unsigned pair = reply.counts[i] | unsigned{reply.counts[i + 1]} << 12;
            for (const unsigned shift : {0U, 8U, 16U}) payload.add(pair >> shift & 0xff);
        }
    }
    payload.add(unsigned{reply.status});
    append_frame(payload.bytes(), out);
}

std::optional<Reply> read_reply(std::span<const std::byte> payload) {
    if (payload.empty()) return std::nullopt;
    Cursor cursor(payload);
    const unsigned header = cursor.byte();
    const auto mode = mode_of(header);
    if (!mode) return std::nullopt;
    Reply reply{.mode = *mode, .variant = static_cast<Variant>(header & 0xf)};
    const bool has_sensors = reply.variant != Variant::current_and_velocity;
    if (payload.size() != (has_sensors ? size_with_sensors : size_without_sensors)) return std::nullopt;
    for (std::size_t i = 0; i < motors; ++i) {
        reply.position_deg[i] = cursor.number(per_degree);
        if (reply.variant == Variant::velocity_and_sensors)
            reply.velocity_deg_per_s[i] = cursor.number(per_rotor_degree_per_s);
        else
            reply.current_a[i] = cursor.number(per_ampere);
    }
    if (has_sensors)
        for (std::size_t i = 0; i < sensors; i += 2) cursor.pair(reply.counts[i], reply.counts[i + 1]);
    else
        for (double& velocity : reply.velocity_deg_per_s) velocity = cursor.number(per_rotor_degree_per_s);
    reply.status = cursor.byte();
    return reply;
}

std::optional<Request> read_request(std::uint8_t address, std::span<const std::byte> payload) {
    if (payload.size() < 2) return std::nullopt;
    Cursor cursor(payload);
    if (cursor.byte() != address) return std::nullopt;
    const unsigned header = cursor.byte();
    const auto mode = mode_of(header);
    if (!mode) return std::nullopt;
    Request request{.command = {.mode = *mode}, .variant = static_cast<Variant>(header & 0xf)};
    if (payload.size() != (*mode == Mode::read_only ? 2 : 2 + 2 * motors)) return std::nullopt;
    if (*mode != Mode::read_only)
        for (double& value : request.command.values) value = cursor.number(per_unit(*mode));
    return request;
}

std::span<const std::byte> FrameReader::add(std::byte byte) noexcept {
    if (byte == flag) return end_frame();
    if (byte == escape) {
        bad_ |= escaped_;
        escaped_ = true;
        return {};
    }
    if (escaped_) byte ^= escape_mask;
    escaped_ = false;
    if (size_ == longest)
        bad_ = true;
    else
        bytes_[size_++] = byte;
    return {};
}

std::span<const std::byte> FrameReader::end_frame() noexcept {
    const auto frame = std::span<const std::byte>(bytes_).first(size_);
    const bool good = !bad_ && !escaped_ && size_ >= 2 && (sum(frame) & 0xff) == 0;
    const bool nulls = !bad_ && !escaped_ && sum(frame) == 0;
    size_ = 0;
    bad_ = escaped_ = false;
    if (nulls) return {};
    if (!good) ++refused_;
    return good ? frame.first(frame.size() - 1) : std::span<const std::byte>();
}

}  // namespace afferent::ability_hand
