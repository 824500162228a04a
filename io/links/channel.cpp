#include "afferent/io/links/channel.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

void require_probability(const char* field, double value) {
    require(value >= 0 && value <= 1, field, "from 0 to 1", value);
}

}  // namespace

void ChannelParameters::check() const {
    require(bandwidth_bps >= 0, "bandwidth_bps", ">= 0", bandwidth_bps);
    require(latency >= Duration::zero(), "latency_ms", ">= 0", Milliseconds(latency).count());
    require(jitter >= Duration::zero(), "jitter_ms", ">= 0", Milliseconds(jitter).count());
    require_probability("loss", loss);
    require_probability("reorder", reorder);
    require_probability("duplicate", duplicate);
    require_probability("corrupt", corrupt);
}

Channel::Channel(const ChannelParameters& parameters) : parameters_(parameters), random_(parameters.seed) {
    parameters_.check();
}

void Channel::send(TimePoint now, std::span<const std::byte> frame, std::uint32_t events) {
    transmit(now);
    ++counts_.sent;
    if (!make_room(events)) {
        ++counts_.dropped;
        return;
    }
    waiting_.push_back({.bytes = {frame.begin(), frame.end()}, .events = events, .sent = now});
    waiting_events_ += events;
    waiting_bytes_ += frame.size();
    transmit(now);
}

std::optional<TimePoint> Channel::next_change() const {
    if (empty()) return std::nullopt;
    const TimePoint arrival = flying_.empty() ? TimePoint::max() : flying_.begin()->first;
    const TimePoint departure =
        waiting_.empty() ? TimePoint::max() : std::max(free_at_, waiting_.front().sent);
    return std::min(arrival, departure);
}

std::optional<TimePoint> Channel::next_arrival(TimePoint until) {
    transmit(until);
    if (flying_.empty() || flying_.begin()->first > until) return std::nullopt;
    return flying_.begin()->first;
}

std::span<const std::byte> Channel::arrive() {
    assert(!flying_.empty());
    arrived_ = std::move(flying_.extract(flying_.begin()).mapped());
    flying_bytes_ -= arrived_.size();
    ++counts_.arrived;
    return arrived_;
}

// Starts every transmission that begins at or before this time.
void Channel::transmit(TimePoint until) {
    while (!waiting_.empty()) {
        const TimePoint begin = std::max(free_at_, waiting_.front().sent);
        if (begin > until) return;
        Frame frame = take_waiting();
        Duration taken = Duration::zero();
        if (parameters_.bandwidth_bps > 0)
            taken = Duration(
                std::llround(8e9 * static_cast<double>(frame.bytes.size()) / parameters_.bandwidth_bps));
        free_at_ = begin + taken;
        fly(std::move(frame.bytes), free_at_);
    }
}

void Channel::fly(std::vector<std::byte> frame, TimePoint sent) {
    // All numbers are drawn in the same order whatever happens to the frame, so that one probability does not
    // change what another does.
    const bool lost = happens(parameters_.loss);
    const bool corrupted = happens(parameters_.corrupt);
    const bool duplicated = happens(parameters_.duplicate);
    const bool reordered = happens(parameters_.reorder);
    if (lost) {
        ++counts_.lost;
        return;
    }
    if (corrupted && !frame.empty()) {
        ++counts_.corrupted;
        const std::uint64_t bit = random_() % (8 * frame.size());
        frame[bit / 8] ^= std::byte{1} << (bit % 8);
    }
    const auto jitter = [&] {
        return Duration(std::llround(uniform() * static_cast<double>(parameters_.jitter.count())));
    };
    TimePoint arrival = std::max(last_arrival_, sent + parameters_.latency + jitter());
    if (reordered) {
        ++counts_.reordered;
        arrival += parameters_.latency + jitter();
    } else {
        last_arrival_ = arrival;
    }
    if (duplicated) {
        ++counts_.duplicated;
        arrive_at(arrival + jitter(), frame);
    }
    arrive_at(arrival, std::move(frame));
}

void Channel::arrive_at(TimePoint time, std::vector<std::byte> frame) {
    flying_bytes_ += frame.size();
    flying_.emplace(time, std::move(frame));
}

Channel::Frame Channel::take_waiting() {
    Frame frame = std::move(waiting_.front());
    waiting_.pop_front();
    waiting_events_ -= frame.events;
    waiting_bytes_ -= frame.bytes.size();
    return frame;
}

bool Channel::make_room(std::uint32_t events) {
    if (parameters_.fifo_events == 0) return true;
    while (!waiting_.empty() && waiting_events_ + events > parameters_.fifo_events) {
        if (parameters_.drop_policy == DropPolicy::newest) return false;
        take_waiting();
        ++counts_.dropped;
    }
    return true;
}

}  // namespace afferent
