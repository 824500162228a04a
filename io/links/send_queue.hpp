// A queue of frames to send: bounded, dropping the oldest packets; or lossless.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

namespace afferent {

class SendQueue {
  public:
    enum class Kind : std::uint8_t {
        message,  // is never dropped
        packet,
        follower,  // a packet that cannot be read without the one before: it is dropped with that
    };

    // Lossless: takes everything, whatever the limit is.
    explicit SendQueue(std::size_t limit_bytes, bool lossless = false)
        : limit_bytes_(limit_bytes), lossless_(lossless) {}

    enum class Pushed {
        whole,
        dropped,   // older packets, to make room, and this one if it follows them
        overflow,  // four times the limit in frames that must not be dropped; this one was not queued
    };
    // An empty queue takes a frame of any size.
    Pushed push(std::span<const std::byte> frame, Kind kind);

    // Moves complete frames to the end of `out`: at least one, and more while they add up to at most `most`
    // bytes.
    void take(std::vector<std::byte>& out, std::size_t most);

    bool empty() const noexcept { return frames_.empty(); }
    std::size_t bytes() const noexcept { return bytes_; }
    std::uint64_t dropped() const noexcept { return dropped_; }

  private:
    struct Frame {
        std::vector<std::byte> bytes;
        Kind kind = Kind::message;
    };

    bool drop_oldest_packet();
    void drop(std::deque<Frame>::iterator frame);
    void recycle(Frame&& frame);

    std::size_t limit_bytes_;
    bool lossless_;
    std::size_t bytes_ = 0;
    std::uint64_t dropped_ = 0;
    bool newest_is_dropped_ = false;  // of the packets so far
    std::deque<Frame> frames_;
    std::vector<std::vector<std::byte>> spare_;  // so that frames are not allocated each time
};

}  // namespace afferent
