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
#include "afferent/io/wire/result.hpp"

namespace afferent {

struct RelayParameters {
    ChannelParameters to_hand;
    ChannelParameters to_coprocessor;
    // How many events a datagram frame holds, for fifo_events; none: no frame holds any.
    std::function<std::uint32_t(std::span<const std::byte>)> events;
};

// Frames both ways, over all connections so far.
struct RelayCounts {
    ChannelCounts to_hand;
    ChannelCounts to_coprocessor;
    std::uint64_t connections = 0;
};

// Stands where the coprocessor looks for the hand, and reaches the hand for it. Unix sockets, TCP and plain
// UDP are relayed frame by frame; of TLS it is whatever is read at once, of sealed UDP the datagram, of a
// serial line what lies between two zero bytes. It reads no key and needs none. Where a reader is too slow it
// reads less itself, and a datagram is dropped.
class Relay {
  public:
    // A serial line is not there before: a pair of pseudo-terminals is made, one end of which appears, as a
    // link, at `from`, for the coprocessor, and one at `to`, for the hand.
    static Result<std::unique_ptr<Relay>> open(boost::asio::io_context& io, const LinkAddress& from,
                                               const LinkAddress& to, const RelayParameters& parameters);
    virtual ~Relay() = default;

    // Where the coprocessor finds it: `from`, with the port that was found for port 0.
    virtual LinkAddress address() const = 0;
    virtual RelayCounts counts() const = 0;

    // As a cable that is pulled, or plugged in again: nothing passes, and nobody is told.
    virtual void pull(bool pulled) = 0;
};

// Where a coprocessor finds the channel to the hand at that address: the next port, or the path with
// ".channel" after it.
LinkAddress channel_address(const LinkAddress& hand);

}  // namespace afferent
