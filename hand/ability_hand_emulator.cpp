#include "afferent/hand/ability_hand_emulator.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/hand/random.hpp"

namespace afferent {
namespace {

using ability_hand::Mode;

constexpr Duration longest_step = 1ms;
constexpr double motor_lag_s = 0.03;
constexpr double mm_per_deg = 0.7;
constexpr double highest_deg = 120;
constexpr std::size_t rotator = ability_hand::motors - 1;

constexpr std::array<double, ability_hand::flexors> finger_share{0.125, 0.125, 0.125, 0.125, 0.5};
constexpr std::array<double, ability_hand::sensors_per_finger> sensor_share{0.3, 0.25, 0.2, 0.12, 0.08, 0.05};

// The force at which a driven flexor stalls, for a finger that has an eighth of the grip, and the servo's
// laws.
constexpr double stall_n = 4;
constexpr double servo_per_s = 10;
constexpr double servo_n_per_deg = 0.25;
constexpr double motor_n_per_a = 6;
constexpr double deg_per_s_per_n = 60;
constexpr double deg_per_s_at_full_duty = 250;
constexpr double friction_a = 0.05;

// Where the finger presses, a flexor that closes slows down in proportion to the force.
double loaded(double deg_per_s, double force_n) {
    return deg_per_s > 0 ? deg_per_s * (1 - force_n / stall_n) : deg_per_s;
}

}  // namespace

AbilityHandEmulator::AbilityHandEmulator(const Parameters& parameters) : parameters_(parameters) {}

std::array<double, ability_hand::sensors> AbilityHandEmulator::shares() noexcept {
    std::array<double, ability_hand::sensors> shares{};
    for (std::size_t i = 0; i < shares.size(); ++i)
        shares[i] = finger_share[i / sensor_share.size()] * sensor_share[i % sensor_share.size()];
    return shares;
}

void AbilityHandEmulator::receive(TimePoint now, std::span<const std::byte> bytes) {
    advance(now);
    if (faults_.frozen) return;
    // The line takes its time, whatever carries the bytes here.
    line_free_ = std::max(line_free_, now) + byte_time(bytes.size());
    reader_.read(bytes, [&](std::span<const std::byte> payload) {
        const auto request = ability_hand::read_request(parameters_.address, payload);
        if (!request) return;
        ++requests_;
        if (request->command.mode != Mode::read_only) {
            heard_ = now;
            command_ = request->command;
            driven_ = true;
        }
        asked_ = request;
        answer(line_free_);
    });
}

void AbilityHandEmulator::answer(TimePoint arrived) {
    reply_.clear();
    if (faults_.nonsense) {
        for (int i = 0; i < 80; ++i) reply_.push_back(static_cast<std::byte>(random() * 256));
    } else {
        ability_hand::append_reply(reply(), reply_);
        damage();
    }
    reply_at_ = line_free_ = arrived + byte_time(reply_.size());
}

std::optional<TimePoint> AbilityHandEmulator::next_reply() const noexcept {
    return reply_.empty() ? std::nullopt : std::optional(reply_at_);
}

void AbilityHandEmulator::send(TimePoint now, std::vector<std::byte>& out) {
    if (reply_.empty() || now < reply_at_) return;
    if (!faults_.frozen) out.insert(out.end(), reply_.begin(), reply_.end());
    reply_.clear();
}

void AbilityHandEmulator::damage() {
    const LineNoise& noise = parameters_.noise;
    double drawn = random();
    const auto happens = [&drawn](double probability) {
        drawn -= probability;
        return drawn < 0 && drawn >= -probability;
    };
    const auto place = [this] {
        return static_cast<std::ptrdiff_t>(random() * static_cast<double>(reply_.size()));
    };
    const std::vector<std::byte> whole = reply_;
    if (happens(noise.lost_beginning))
        reply_.erase(reply_.begin(), reply_.begin() + 1 + place());
    else if (happens(noise.nulls))
        reply_.insert(reply_.begin() + place(), 1 + static_cast<std::size_t>(random() * 3), std::byte{0});
    else if (happens(noise.flipped_bit))
        reply_[static_cast<std::size_t>(place())] ^= std::byte(1U << static_cast<unsigned>(random() * 8));
    else if (happens(noise.half_frame))
        reply_.resize(static_cast<std::size_t>(place()));
    else if (happens(noise.no_reply))
        reply_.clear();
    if (reply_ != whole) ++damaged_;
}

ability_hand::Reply AbilityHandEmulator::reply() {
    ability_hand::Reply reply{.mode = asked_->command.mode, .variant = asked_->variant};
    for (std::size_t i = 0; i < ability_hand::motors; ++i) {
        reply.position_deg[i] = motors_[i].position_deg;
        reply.velocity_deg_per_s[i] = motors_[i].velocity_deg_per_s;
        const double pressing_n = i < ability_hand::flexors ? finger_n(i) * 0.125 / finger_share[i] : 0;
        const double moving = motors_[i].velocity_deg_per_s == 0 ? 0 : friction_a;
        reply.current_a[i] =
            pressing_n / motor_n_per_a + std::copysign(moving, motors_[i].velocity_deg_per_s);
    }
    ++readings_;
    const auto shares = AbilityHandEmulator::shares();
    for (std::size_t i = 0; i < ability_hand::sensors; ++i) {
        const auto sensor = static_cast<std::uint32_t>(i);
        const double untouched = parameters_.untouched_counts *
                                 (0.5 + uniform(parameters_.seed, Stream::untouched_reading, sensor, 0));
        const double force_n = (grip_n() + faults_.pressing_n) * shares[i];
        const double counts =
            ability_hand::counts_at(ability_hand::force_n(untouched) + force_n) +
            parameters_.noise_counts * gaussian(parameters_.seed, Stream::sensor_noise, sensor, readings_);
        reply.counts[i] = faults_.stuck_counts[i].value_or(static_cast<std::uint16_t>(
            std::lround(std::clamp<double>(counts, 0, ability_hand::most_counts))));
    }
    return reply;
}

void AbilityHandEmulator::advance(TimePoint now) {
    while (now_ < now) {
        const Duration step = std::min(now - now_, longest_step);
        now_ += step;
        if (now_ - heard_ >= ability_hand::leaves_mode_after) driven_ = false;
        this->step(seconds(step));
    }
}

void AbilityHandEmulator::step(double seconds) noexcept {
    for (std::size_t i = 0; i < ability_hand::motors; ++i) {
        Motor& motor = motors_[i];
        motor.velocity_deg_per_s +=
            (asked_deg_per_s(i) - motor.velocity_deg_per_s) * -std::expm1(-seconds / motor_lag_s);
        const double lowest = i == rotator ? -highest_deg : 0;
        const double highest = i == rotator ? 0 : highest_deg;
        const double to = motor.position_deg + motor.velocity_deg_per_s * seconds;
        motor.position_deg = std::clamp(to, lowest, highest);
        if (motor.position_deg != to) motor.velocity_deg_per_s = 0;
    }
    highest_grip_n_ = std::max(highest_grip_n_, grip_n());
}

double AbilityHandEmulator::asked_deg_per_s(std::size_t i) const noexcept {
    if (!driven_) return 0;
    const double asked = command_.values[i];
    const double force_n = i < ability_hand::flexors ? finger_n(i) * 0.125 / finger_share[i] : 0;
    switch (command_.mode) {
        case Mode::position:
            return std::clamp(servo_per_s * (asked - motors_[i].position_deg - force_n / servo_n_per_deg),
                              -250.0, 250.0);
        case Mode::velocity:
            return loaded(asked, force_n);
        case Mode::current: {
            const double driving_n = motor_n_per_a * asked - force_n;
            const double friction_n = motor_n_per_a * friction_a;
            return std::abs(driving_n) < friction_n
                       ? 0
                       : deg_per_s_per_n * (driving_n - std::copysign(friction_n, driving_n));
        }
        case Mode::duty:
            return loaded(asked / 100 * deg_per_s_at_full_duty, force_n);
        case Mode::read_only:
            break;
    }
    return 0;
}

double AbilityHandEmulator::finger_n(std::size_t finger) const noexcept {
    const double pressed_mm = mm_per_deg * motors_[finger].position_deg - parameters_.distance_mm;
    return finger_share[finger] * parameters_.stiffness_n_per_mm * std::max(0.0, pressed_mm);
}

double AbilityHandEmulator::grip_n() const noexcept {
    double sum_n = 0;
    for (std::size_t i = 0; i < ability_hand::flexors; ++i) sum_n += finger_n(i);
    return sum_n;
}

double AbilityHandEmulator::random() noexcept {
    return uniform(parameters_.seed, Stream::line_noise, 0, drawn_++);
}

Duration AbilityHandEmulator::byte_time(std::size_t bytes) const noexcept {
    // A start bit, eight of data, a stop bit.
    return Duration(std::int64_t{10'000'000'000} * static_cast<std::int64_t>(bytes) / parameters_.baud);
}

}  // namespace afferent
