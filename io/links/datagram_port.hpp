// Where datagrams go out and come in: a UDP socket, or a serial line.
#pragma once

#include <boost/asio/ip/udp.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "afferent/io/links/link.hpp"
#include "afferent/io/wire/result.hpp"

namespace afferent {

// Where a datagram came from, or goes to; on a serial line always the same.
using DatagramPeer = boost::asio::ip::udp::endpoint;

// Who has a port. Each call may close it.
class DatagramPortUser {
  public:
    virtual ~DatagramPortUser() = default;

    virtual void received(const DatagramPeer& from, std::span<const std::byte> datagram) = 0;
    // Between datagrams something came in that was none: so many pieces of it.
    virtual void received_garbage(std::uint64_t pieces) = 0;
    // After a send that could not be: the next can.
    virtual void writable() = 0;
    // The last call: the port is of no use any more.
    virtual void failed(const Error& error) = 0;
};

// All calls are made on the one thread that runs the port's I/O; calls to the user come from its loop.
class DatagramPort {
  public:
    virtual ~DatagramPort() = default;

    // To be called once. The user holds the port, and not the other way round.
    virtual void start(std::weak_ptr<DatagramPortUser> user) = 0;
    // Takes the datagram now, and says how many bytes that are on the line; or not at all: 0, and writable()
    // will be called. What the network does with it is not known.
    virtual std::size_t send(const DatagramPeer& to, std::span<const std::byte> datagram) = 0;
    // What was sent still goes out. No more calls to the user.
    virtual void close() = 0;
};

using OpenDatagramPort = std::function<Result<std::shared_ptr<DatagramPort>>()>;

}  // namespace afferent
