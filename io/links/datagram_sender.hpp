// Sends datagrams to a program on this machine, and never waits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "afferent/runtime/result.hpp"

namespace afferent {

class DatagramSender {
  public:
    // To a UDP port. The host is localhost or an address in digits; `not_allowed` unless it is this
    // machine's, since nothing protects what is sent.
    static Result<DatagramSender> to_udp(const std::string& host, std::uint16_t port);
    // To a Unix socket of datagrams, which need not be there yet. `not_allowed` where no socket can have that
    // path.
    static Result<DatagramSender> to_unix(const std::string& path);

    // Whether the system has taken it: not where its queue is full, or where a Unix socket has no reader. UDP
    // does not tell whether anybody listens.
    bool send(std::span<const std::byte> datagram);

    struct Socket;

  private:
    explicit DatagramSender(std::shared_ptr<Socket> socket) : socket_(std::move(socket)) {}

    std::shared_ptr<Socket> socket_;
};

}  // namespace afferent
