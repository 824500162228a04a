// A channel that loses, delays, repeats, reorders and changes frames, in virtual time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "afferent/runtime/time.hpp"

namespace afferent {

enum class DropPolicy : std::uint8_t { oldest, newest };

// By default the channel changes nothing. Each probability holds for each frame, independently of the others.
struct ChannelParameters {
    double bandwidth_bps = 0;  // 0: without limit
    Duration latency = Duration::zero();
    Duration jitter = Duration::zero();  // added to the latency, uniform from 0; frames stay in order
    double loss = 0;
    double reorder = 0;  // delayed by latency and jitter a second time, so that later frames may overtake it
    double duplicate = 0;
    double corrupt = 0;             // one bit is changed
    std::uint32_t fifo_events = 0;  // how many events may wait for the bandwidth; 0: without limit
    DropPolicy drop_policy = DropPolicy::oldest;
    std::uint64_t seed = 1;

    // Throws ParameterError, with the names of the scene's channel.
    void check() const;
};

// sent + duplicated = arrived + lost + dropped + those in transit.
struct ChannelCounts {
    std::uint64_t sent = 0;
    std::uint64_t arrived = 0;
    std::uint64_t lost = 0;
    std::uint64_t dropped = 0;  // because the queue was full
    std::uint64_t duplicated = 0;
    std::uint64_t corrupted = 0;
    std::uint64_t reordered = 0;
};

// One direction. Frames are transmitted one after the other at the bandwidth and wait in a queue before that.
//
//     channel.send(now, frame, events);
//     while (const auto due = channel.next_arrival(until)) { use(channel.arrive()); }
class Channel {
  public:
    // Throws ParameterError.
    explicit Channel(const ChannelParameters& parameters);

    // Times must not decrease, from call to call of send() and next_arrival().
    void send(TimePoint now, std::span<const std::byte> frame, std::uint32_t events);

    // When the next frame arrives, if that is at or before `until`.
    std::optional<TimePoint> next_arrival(TimePoint until);

    // The frame that next_arrival() has announced; it stays valid until the next call of any kind.
    std::span<const std::byte> arrive();

    // When the next frame arrives or is transmitted, for a caller that sleeps until then. Nothing if the
    // channel is empty.
    std::optional<TimePoint> next_change() const;

    bool empty() const noexcept { return waiting_.empty() && flying_.empty(); }
    // The size of the frames that wait for the bandwidth.
    std::size_t waiting_bytes() const noexcept { return waiting_bytes_; }
    // The size of all frames, waiting or in transit.
    std::size_t bytes() const noexcept { return waiting_bytes_ + flying_bytes_; }
    const ChannelCounts& counts() const noexcept { return counts_; }

  private:
    struct Frame {
        std::vector<std::byte> bytes;
        std::uint32_t events = 0;
        TimePoint sent;
    };

    void transmit(TimePoint until);
    void fly(std::vector<std::byte> frame, TimePoint sent);
    void arrive_at(TimePoint time, std::vector<std::byte> frame);
    Frame take_waiting();
    bool make_room(std::uint32_t events);
    // From 0 to below 1, from the generator's top bits: the standard's distributions differ between
    // libraries.
    double uniform() { return static_cast<double>(random_() >> 11) * 0x1p-53; }
    bool happens(double probability) { return probability > 0 && uniform() < probability; }

    ChannelParameters parameters_;
    std::mt19937_64 random_;
    std::deque<Frame> waiting_;
    std::uint64_t waiting_events_ = 0;
    std::size_t waiting_bytes_ = 0;
    TimePoint free_at_ = scene_start;  // when the current transmission ends
    TimePoint last_arrival_ = scene_start;
    std::multimap<TimePoint, std::vector<std::byte>> flying_;  // by arrival; ties in the order of insertion
    std::size_t flying_bytes_ = 0;
    std::vector<std::byte> arrived_;
    ChannelCounts counts_;
};

}  // namespace afferent
