// A link to one peer: messages in both directions, never blocking, everything that is lost counted.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>

#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/messages.hpp"
#include "afferent/runtime/result.hpp"

namespace afferent {

struct LinkOptions {
    // How much the kernel may buffer, each way. It is small because what waits there is old when it is read.
    std::size_t kernel_buffer_bytes = std::size_t{16} * 1024;
    // How much is queued when the kernel takes no more. Beyond that the oldest packets are dropped.
    std::size_t queue_bytes = std::size_t{64} * 1024;
    // Lockstep: nothing is dropped, and the queue holds whatever it is given. The sender looks at
    // queued_bytes() and waits.
    bool lossless = false;
    // A peer that does not acknowledge for this long is gone, where the transport can tell.
    std::chrono::milliseconds silence_limit{1000};
    // A peer that has been silent for this long makes way for another; until then the other is turned away.
    // 0: it keeps its place as long as its connection lives, as in lockstep.
    std::chrono::milliseconds alive_limit{150};
};

struct LinkCounts {
    // Bytes, here and in `bytes_out`, are those that the transport carried, framing and encryption included.
    FrameCounts in;
    std::uint64_t bytes_out = 0;
    std::uint64_t dropped = 0;  // outgoing packets, because the peer reads too slowly
};

// What a link reports. Each may close or destroy the link.
struct LinkCallbacks {
    std::function<void(const proto::Envelope&)> message;
    // A frame was dropped; the link goes on.
    std::function<void(const Error&)> bad_frame;
    // The last call, unless close() or the destructor came first.
    std::function<void(const Error&)> closed;
};

// Owned by a session; on destruction it closes at once, without another callback. All calls are made on the
// one thread that runs the link's I/O.
class Link {
  public:
    virtual ~Link() = default;

    // To be called once. Callbacks come from the I/O loop, not from within calls to the link.
    virtual void start(LinkCallbacks callbacks) = 0;

    // True if nothing was dropped. When the queue is full, the oldest packets are dropped, but for a lossless
    // link, and the receiver sees a gap. Other messages are never dropped; a peer that leaves them unread is
    // disconnected.
    virtual bool send(const proto::Envelope& message) = 0;

    // Sends what is queued, then closes. No more callbacks.
    virtual void close() = 0;

    // Bytes sent by us and not yet taken by the kernel.
    virtual std::size_t queued_bytes() const = 0;

    // Whether frames arrive in order and complete, or not at all.
    virtual bool ordered() const = 0;

    virtual const LinkCounts& counts() const = 0;
};

}  // namespace afferent
