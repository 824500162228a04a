// A connection over a stream, from its first byte on. For the transports.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "afferent/io/links/connection_link.hpp"

namespace afferent {

// Takes a few kilobytes until it is started, and the length of the peer's first message.
class StreamPeer : public Connection {
  public:
    // The first message, or why there is none.
    using OnFirst = std::function<void(const Result<const proto::Envelope*>&)>;

    // Reads the first message and no further. start() goes on from there, and calls back with it.
    virtual void await_first(OnFirst on_first) = 0;
    // When the last good frame came.
    virtual std::chrono::steady_clock::time_point last_heard() const = 0;
    // Closes, and reports this reason as if the peer had gone.
    virtual void give_way(const Error& reason) = 0;
};

// A connection, or why there is none.
using OnStreamPeer = std::function<void(const Result<std::shared_ptr<StreamPeer>>&)>;

// Called in place of start(): tells the peer why, and closes.
enum class Refusal { for_good, for_now };
void refuse(StreamPeer& peer, const std::string& text, Refusal refusal);

}  // namespace afferent
