// An output that sends address events to other programs on this machine, in the form that jAER reads from a
// network.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "afferent/engine/controller.hpp"
#include "afferent/io/files/table_writer.hpp"
#include "afferent/io/links/datagram_sender.hpp"
#include "afferent/nodes/output_thread.hpp"

namespace afferent {

// A datagram is a sequence number and up to 128 events, all numbers unsigned, of 32 bits, most significant
// byte first:
//
//     number of the datagram    0 in the first of them
//     address, time in µs       of each event, in their order; the time is the scene's, modulo 2^32
//
// What was sent in one span goes out when the span is known. Nothing waits: events of a datagram that the
// system does not take are lost and counted, and its number is used, so that the reader sees the gap.
class LiveEvents {
  public:
    static constexpr OutputThread thread = OutputThread::link;
    using Described = scene::LiveEvents;
    static constexpr std::size_t most_events = 128;

    // `not_allowed` where the events would leave the machine.
    static Result<LiveEvents> open(const Scene& scene, const Described& given, FullPipe = FullPipe::wait);

    void observe(const TimeSpan& span, std::span<const Event> events);
    void take(const ControllerStep&) noexcept {}
    Result<void> close() { return success(); }
    OutputLosses lost() const noexcept { return {.steps = 0, .events = lost_}; }
    std::optional<std::string> notice() const { return std::nullopt; }

  private:
    explicit LiveEvents(DatagramSender sender) : sender_(std::move(sender)) {}

    DatagramSender sender_;
    std::vector<std::byte> datagram_;
    std::uint32_t number_ = 0;
    std::uint64_t lost_ = 0;
};

}  // namespace afferent
