// Sends and receives datagrams: over a UDP socket, or a serial line.
#pragma once

#include <boost/asio/ip/udp.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "afferent/io/links/link.hpp"
#include "afferent/runtime/result.hpp"

namespace afferent {

// The address of the other end; on a serial line always the same.
using DatagramPeer = boost::asio::ip::udp::endpoint;

// The properties of the line that carries the datagrams.
struct DatagramLine {
    // The longest datagram that a handshake should send. Short ones survive on a noisy line.
    std::size_t handshake_bytes = 1200;
    // How long a byte takes; 0 where that does not matter.
    std::chrono::nanoseconds byte_time{};
    // How many bytes the line carries for a datagram.
    std::size_t (*bytes_of)(std::span<const std::byte> datagram) = [](std::span<const std::byte> datagram) {
        return datagram.size();
    };
};

// Bytes on a line, each way.
struct CarriedBytes {
    std::uint64_t in = 0;
    std::uint64_t out = 0;
};

// What a port calls back. Each call may close the port.
class DatagramPortUser {
  public:
    virtual ~DatagramPortUser() = default;

    virtual void received(const DatagramPeer& from, std::span<const std::byte> datagram) = 0;
    // Bytes came in that were not a datagram; how many times.
    virtual void received_garbage(std::uint64_t pieces) = 0;
    // After a send that failed for want of room: there is room.
    virtual void writable() = 0;
    // The last call: the port can no longer be used.
    virtual void failed(const Error& error) = 0;
};

// All calls are made on the one thread that runs the port's I/O; calls to the user come from its loop.
class DatagramPort {
  public:
    virtual ~DatagramPort() = default;

    // To be called once. The user owns the port, not the port its user.
    virtual void start(std::weak_ptr<DatagramPortUser> user) = 0;
    // Returns how many bytes the datagram takes on the line, or 0 if it was not sent: then writable() will be
    // called. Whether it arrives is not known.
    virtual std::size_t send(const DatagramPeer& to, std::span<const std::byte> datagram) = 0;
    virtual DatagramLine line() const { return {}; }
    // What was sent still goes out. No more callbacks.
    virtual void close() = 0;
};

using OpenDatagramPort = std::function<Result<std::shared_ptr<DatagramPort>>()>;

}  // namespace afferent
