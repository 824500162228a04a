#include "afferent/nodes/ability_hand_driver.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>

#include "afferent/runtime/overloaded.hpp"

namespace afferent {
namespace {

using ability_hand::Mode;
using ability_hand::sensors;

constexpr std::size_t rotator = ability_hand::motors - 1;
constexpr std::array<const char*, ability_hand::motors> motor_names{"index",  "middle", "ring",
                                                                    "little", "thumb",  "thumb's turn"};

// The longest stretch that a target moves for at once, however long the last request was ago.
constexpr Duration longest_move = 20ms;

// What the hand takes to answer beyond the time of the bytes on the line.
constexpr Duration longest_turnaround = 5ms;

// Bytes of a request and its reply when every byte is escaped, and bits of each.
constexpr std::int64_t most_bytes = 2 * (15 + 72) + 4;
constexpr std::int64_t bits_per_byte = 10;

// A finger's angle that the hand can have.
constexpr double lowest_deg = -20;
constexpr double highest_deg = 150;

constexpr Duration zero_span = 500ms;
constexpr std::uint32_t fewest_zero_replies = 20;
// An untouched sensor's readings vary by no more than this meanwhile.
constexpr int most_zero_range = 60;
// A sensor's force that is told apart in a note.
constexpr double told_n = 0.05;

// Zeros come down to the mean of the readings in so long, by no less than what noise does to that mean.
constexpr Duration lowest_span = 200ms;
constexpr double zero_margin_counts = 3;

// A hand that has been silent for so long is told of.
constexpr Duration told_silence = 1s;

// The hand's temperature is told of no more often than this.
constexpr Duration status_period = 1s;

// The highest readings, which a sensor has under any larger force.
constexpr std::uint16_t saturated_counts = ability_hand::most_counts - 5;
constexpr Duration saturated_after = 200ms;
// A sensor that reads exactly 0 although its zero does not.
constexpr double fewest_live_zero_counts = 4;
constexpr Duration dead_after = 1s;

std::string newtons(double force_n) {
    char text[32];
    std::snprintf(text, sizeof text, "%.2f N", force_n);
    return text;
}

double force_above_n(double counts, double zero_counts) {
    return std::max(0.0, ability_hand::force_n(counts) - ability_hand::force_n(zero_counts));
}

}  // namespace

std::string ability_hand_sensor(std::size_t sensor) {
    return motor_names[sensor / ability_hand::sensors_per_finger] + std::string(" ") +
           std::to_string(sensor % ability_hand::sensors_per_finger + 1);
}

AbilityHandDriver::Parameters ability_hand_driver_parameters(const Plan& plan) {
    AbilityHandDriver::Parameters parameters{.hand = *plan.scene.hand.ability_hand,
                                             .full_scale_n = {},
                                             .freeze = plan.timing.freeze,
                                             .safe = plan.timing.safe};
    std::size_t element = 0;
    for (const PatchPlan& patch : plan.patches)
        for (std::uint32_t i = 0; patch.owns_elements && i < patch.elements(); ++i)
            parameters.full_scale_n[element++] = patch.sensor.full_scale_n;
    return parameters;
}

AbilityHandDriver::AbilityHandDriver(const Parameters& parameters, MonotonicTime now)
    : parameters_(parameters),
      period_(from_seconds(1 / parameters.hand.rate_hz)),
      next_request_(now),
      silent_since_(now) {
    if (!parameters.hand.zero_counts.empty())
        std::copy_n(parameters.hand.zero_counts.begin(), sensors, base_counts_.begin());
    zero_counts_ = base_counts_;
    request_.reserve(64);
    readings_.motor_count = ability_hand::motors;
    readings_.sensor_count = sensors;
}

Duration AbilityHandDriver::patience() const noexcept {
    return longest_turnaround + Duration(1'000'000'000 * bits_per_byte * most_bytes / parameters_.hand.baud);
}

void AbilityHandDriver::read(MonotonicTime now, std::span<const std::byte> bytes, const Sample& sample) {
    reader_.read(bytes, [&](std::span<const std::byte> payload) {
        const auto reply = ability_hand::read_reply(payload);
        // What was not asked for is no answer: an echo of the request on a line of two wires, or garbage.
        if (!reply || !asked_at_ || reply->mode != asked_mode_ || !plausible(*reply)) {
            ++readings_.implausible_replies;
            return;
        }
        asked_at_.reset();
        take(now, *reply, sample);
    });
    readings_.refused_frames = reader_.refused();
}

bool AbilityHandDriver::plausible(const ability_hand::Reply& reply) const noexcept {
    if (reply.variant != ability_hand::Variant::current_and_sensors) return false;
    for (std::size_t i = 0; i < ability_hand::motors; ++i) {
        const double turned_deg = i == rotator ? -reply.position_deg[i] : reply.position_deg[i];
        if (turned_deg < lowest_deg || turned_deg > highest_deg) return false;
    }
    return true;
}

void AbilityHandDriver::take(MonotonicTime now, const ability_hand::Reply& reply, const Sample& sample) {
    ++readings_.replies;
    replied_ = silent_since_ = now;
    if (std::exchange(silence_told_, false)) notes_.push_back("the hand answers again");
    position_deg_ = reply.position_deg;
    for (std::size_t i = 0; i < ability_hand::motors; ++i)
        readings_.motors[i] = {motor_names[i], reply.position_deg[i], reply.current_a[i]};
    watch_temperature(now, reply.status);
    watch_sensors(now, reply);
    lower_zeros(now, reply);
    if (zero_) add_to_zero(now, reply);
    for (std::size_t i = 0; i < sensors; ++i) {
        const double full_scale_n = parameters_.full_scale_n[i];
        forces_n_[i] = reply.counts[i] >= saturated_counts
                           ? full_scale_n
                           : std::min(force_above_n(reply.counts[i], zero_counts_[i]), full_scale_n);
    }
    samples_[(first_sample_ + sample_count_) % samples_.size()] = now;
    if (sample_count_ < samples_.size())
        ++sample_count_;
    else
        first_sample_ = (first_sample_ + 1) % samples_.size();
    sample(now, forces_n_);
}

void AbilityHandDriver::watch_temperature(MonotonicTime now, unsigned status) {
    readings_.temperature_status = status;
    if (status == told_status_ || now - status_told_at_ < status_period) return;
    told_status_ = status;
    status_told_at_ = now;
    notes_.push_back(status == 0 ? "the hand is neither hot nor cold any more"
                                 : "the hand says that it is hot or cold: status " + std::to_string(status));
}

void AbilityHandDriver::lower_zeros(MonotonicTime now, const ability_hand::Reply& reply) {
    ++latest_.replies;
    for (std::size_t i = 0; i < sensors; ++i) latest_.sum[i] += reply.counts[i];
    if (now < latest_.until) return;
    if (latest_.replies >= fewest_zero_replies) {
        std::string where;
        for (std::size_t i = 0; i < sensors; ++i) {
            const double counts = latest_.sum[i] / latest_.replies;
            if (counts >= zero_counts_[i] - zero_margin_counts) continue;
            if (force_above_n(zero_counts_[i], counts) >= told_n)
                where += (where.empty() ? "" : ", ") + ability_hand_sensor(i);
            zero_counts_[i] = counts;
        }
        if (!where.empty())
            notes_.push_back("zero_counts are too high, and have been lowered to what the sensors read: " +
                             where);
    }
    latest_ = {.until = now + lowest_span};
}

void AbilityHandDriver::watch_sensors(MonotonicTime now, const ability_hand::Reply& reply) {
    const auto look_at = [&](Watch& watch, bool holds, Duration after, const std::string& sensor,
                             const char* what) {
        if (!holds) {
            watch = {};
            return;
        }
        if (!watch.since) watch.since = now;
        if (watch.told || now - *watch.since < after) return;
        watch.told = true;
        notes_.push_back("sensor " + sensor + what);
    };
    for (std::size_t i = 0; i < sensors; ++i) {
        const bool is_full = reply.counts[i] >= saturated_counts;
        const bool is_dead = reply.counts[i] == 0 && base_counts_[i] >= fewest_live_zero_counts;
        if (!is_full && !is_dead && !saturated_[i].since && !dead_[i].since) continue;
        const std::string name = ability_hand_sensor(i);
        look_at(saturated_[i], is_full, saturated_after, name, " is at full scale");
        look_at(dead_[i], is_dead, dead_after, name, " reads 0, below its zero: is it dead?");
    }
}

void AbilityHandDriver::take_zero(MonotonicTime now) {
    zero_ = Zero{};
    zero_->until = now + zero_span;
    zero_->lowest.fill(ability_hand::most_counts);
}

void AbilityHandDriver::add_to_zero(MonotonicTime now, const ability_hand::Reply& reply) {
    if (now >= zero_->until) return end_zero();
    ++zero_->replies;
    for (std::size_t i = 0; i < sensors; ++i) {
        zero_->sum[i] += reply.counts[i];
        zero_->lowest[i] = std::min(zero_->lowest[i], reply.counts[i]);
        zero_->highest[i] = std::max(zero_->highest[i], reply.counts[i]);
    }
}

void AbilityHandDriver::end_zero() {
    const Zero zero = *std::exchange(zero_, std::nullopt);
    std::string why;
    double hidden_n = 0;
    std::string where;
    std::array<double, sensors> counts{};
    for (std::size_t i = 0; i < sensors && zero.replies > 0; ++i) {
        counts[i] = zero.sum[i] / zero.replies;
        const double more_n = force_above_n(counts[i], base_counts_[i]);
        hidden_n += more_n;
        if (more_n >= told_n)
            where += (where.empty() ? ": " : ", ") + ability_hand_sensor(i) + " by " + newtons(more_n);
        if (why.empty() && zero.highest[i] - zero.lowest[i] > most_zero_range)
            why = "sensor " + ability_hand_sensor(i) + " is not steady";
    }
    if (zero.replies < fewest_zero_replies)
        why = "the hand has answered " + std::to_string(zero.replies) + " times";
    else if (why.empty() && hidden_n > parameters_.hand.zero_drift_n)
        why = "the sensors read " + newtons(hidden_n) + " more than zero_counts" + where +
              ". Does something touch them?";
    if (!why.empty()) {
        ++readings_.zeros_refused;
        notes_.push_back("the zero stays as it was: " + why);
        return;
    }
    ++readings_.zeros_taken;
    zero_counts_ = counts;
    notes_.push_back("the zero has been taken; it differs from zero_counts by " + newtons(hidden_n));
}

bool AbilityHandDriver::is_driven(MonotonicTime now) const noexcept {
    return replied_ && commanded_.at != MonotonicTime() && now - commanded_.at <= parameters_.safe;
}

double AbilityHandDriver::allowed(MonotonicTime now) const noexcept {
    if (std::isnan(commanded_.command)) return 0;
    const double command = std::clamp(commanded_.command, -1.0, 1.0);
    const bool fresh =
        now - commanded_.at <= parameters_.freeze && replied_ && now - *replied_ <= parameters_.freeze;
    return fresh ? command : std::min(command, 0.0);
}

std::span<const std::byte> AbilityHandDriver::poll(MonotonicTime now) {
    watch_silence(now);
    if (asked_at_) {
        // A request right behind one that will still be answered would meet the reply on the line.
        if (now - *asked_at_ < patience()) return {};
        ++readings_.unanswered;
        asked_at_.reset();
    }
    if (now < next_request_) return {};
    const ability_hand::Request request{.command = command(now)};
    request_.clear();
    ability_hand::append_request(static_cast<std::uint8_t>(parameters_.hand.address), request, request_);
    asked_at_ = now;
    asked_mode_ = request.command.mode;
    next_request_ = std::max(next_request_ + period_, now);
    if (request.command.mode == Mode::read_only) {
        sample_count_ = 0;
    } else {
        ++readings_.commands;
        count_latency(now);
    }
    return request_;
}

MonotonicTime AbilityHandDriver::wake() const noexcept {
    return std::max(asked_at_ ? *asked_at_ + patience() : next_request_, next_request_);
}

void AbilityHandDriver::watch_silence(MonotonicTime now) {
    if (silence_told_ || now - silent_since_ < told_silence) return;
    silence_told_ = true;
    const std::string asked = "at address " + std::to_string(parameters_.hand.address) + " and " +
                              std::to_string(parameters_.hand.baud) + " baud";
    notes_.push_back(replied_ ? "the hand does not answer any more"
                              : "the hand does not answer " + asked + ": is it on, and are these its own?");
}

ability_hand::Command AbilityHandDriver::command(MonotonicTime now) {
    if (!is_driven(now)) {
        target_deg_.reset();
        return {.mode = Mode::read_only};
    }
    const double command = allowed(now);
    const scene::AbilityHand& hand = parameters_.hand;
    // Where a finger is at its end, it is not driven any further.
    const auto flexors = [&](Mode mode, double value) {
        ability_hand::Command all{.mode = mode};
        for (std::size_t i = 0; i < ability_hand::flexors; ++i) {
            const bool at_end =
                command > 0 ? position_deg_[i] >= hand.close_deg : position_deg_[i] <= hand.open_deg;
            all.values[i] = at_end ? 0 : value;
        }
        return all;
    };
    return std::visit(Overloaded{[&](const scene::PositionDrive& drive) {
                                     move_targets(command, now, drive);
                                     return ability_hand::Command{Mode::position, *target_deg_};
                                 },
                                 [&](const scene::VelocityDrive& drive) {
                                     return flexors(Mode::velocity, command * drive.speed_deg_per_s);
                                 },
                                 [&](const scene::CurrentDrive& drive) {
                                     return flexors(Mode::current, command * drive.current_a);
                                 },
                                 [&](const scene::DutyDrive& drive) {
                                     return flexors(Mode::duty, command * drive.duty_percent);
                                 }},
                      hand.drive);
}

void AbilityHandDriver::move_targets(double command, MonotonicTime now, const scene::PositionDrive& drive) {
    if (!target_deg_) {
        target_deg_ = position_deg_;
        moved_at_ = now;
    }
    const Duration since = std::min<Duration>(now - std::exchange(moved_at_, now), longest_move);
    const double step_deg = drive.speed_deg_per_s * seconds(since);
    for (std::size_t i = 0; i < ability_hand::flexors; ++i) {
        double& target_deg = (*target_deg_)[i];
        const double asked_deg = target_deg + command * step_deg;
        // A target that is beyond an end, because the finger is, comes back and goes no further.
        if (command > 0) target_deg = std::min(asked_deg, std::max(target_deg, parameters_.hand.close_deg));
        if (command < 0) target_deg = std::max(asked_deg, std::min(target_deg, parameters_.hand.open_deg));
        target_deg =
            std::clamp(target_deg, position_deg_[i] - drive.lead_deg, position_deg_[i] + drive.lead_deg);
    }
    double& turned_deg = (*target_deg_)[rotator];
    turned_deg += std::clamp(parameters_.hand.thumb_rotation_deg - turned_deg, -step_deg, step_deg);
}

void AbilityHandDriver::count_latency(MonotonicTime now) noexcept {
    for (; sample_count_ > 0 && samples_[first_sample_] <= commanded_.known_until; --sample_count_) {
        sample_to_command_.add(now - samples_[first_sample_]);
        first_sample_ = (first_sample_ + 1) % samples_.size();
    }
}

std::optional<std::string> AbilityHandDriver::next_note() {
    if (notes_.empty()) return std::nullopt;
    std::string note = std::move(notes_.front());
    notes_.pop_front();
    return note;
}

const HandReadings& AbilityHandDriver::readings(MonotonicTime now) {
    readings_.answering = replied_ && now - *replied_ <= parameters_.freeze;
    readings_.driven = is_driven(now);
    std::copy(zero_counts_.begin(), zero_counts_.end(), readings_.zero_counts.begin());
    readings_.sample_to_command_p50 = sample_to_command_.quantile(0.5);
    readings_.sample_to_command_p99 = sample_to_command_.quantile(0.99);
    readings_.sample_to_command_max = sample_to_command_.max();
    return readings_;
}

}  // namespace afferent
