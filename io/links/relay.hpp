// A channel between two real processes: what one end sends reaches the other late, changed, twice or never.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "afferent/io/links/asio_forward.hpp"
#include "afferent/io/links/channel.hpp"
#include "afferent/io/links/link_address.hpp"
#include "afferent/runtime/result.hpp"

namespace afferent {

struct RelayParameters {
    ChannelParameters to_hand;
    ChannelParameters to_coprocessor;
    // Counts the events in a frame, for fifo_events. Where this is empty, frames count as having none.
    std::function<std::uint32_t(std::span<const std::byte>)> events;
};

// The frames of both directions, over all connections so far.
struct RelayCounts {
    ChannelCounts to_hand;
    ChannelCounts to_coprocessor;
    std::uint64_t connections = 0;
};

// Listens where the coprocessor looks for the hand, and connects to the hand in its place. Unix sockets, TCP
// and plain UDP are relayed frame by frame, sealed UDP by datagram, a serial line in what is between two zero
// bytes, and TLS in whatever is read at once. It needs no key. If a reader is too slow, it reads less itself,
// or drops datagrams.
class Relay {
  public:
    // For a serial line it makes two pseudo-terminals and symbolic links to them: at `from` for the
    // coprocessor, at `to` for the hand.
    static Result<std::unique_ptr<Relay>> open(boost::asio::io_context& io, const LinkAddress& from,
                                               const LinkAddress& to, const RelayParameters& parameters);
    virtual ~Relay() = default;

    // The address at which coprocessors reach it: `from`, with the port that the system chose in place of
    // port 0.
    virtual LinkAddress address() const = 0;
    virtual RelayCounts counts() const = 0;

    // Like pulling out a cable, or plugging it in again: nothing passes, and neither end is told.
    virtual void pull(bool pulled) = 0;
};

// Where the channel to the hand at this address listens: at the next port, or at the path with ".channel"
// after it.
LinkAddress channel_address(const LinkAddress& hand);

}  // namespace afferent
