// Datagrams of handshakes that the port has not taken yet.
#pragma once

#include <cstddef>
#include <deque>
#include <span>
#include <utility>
#include <vector>

#include "afferent/io/links/datagram_port.hpp"

namespace afferent {

// A flight is several datagrams, and a serial line takes one at a time. When a few flights wait, further
// datagrams are dropped: a handshake repeats what was lost.
class WaitingDatagrams {
  public:
    static constexpr std::size_t most = 32;

    void send(DatagramPort& port, const DatagramPeer& to, std::span<const std::byte> datagram) {
        if (waiting_.empty() && port.send(to, datagram) > 0) return;
        if (waiting_.size() < most) waiting_.emplace_back(to, std::vector(datagram.begin(), datagram.end()));
    }
    void flush(DatagramPort& port) {
        while (!waiting_.empty() && port.send(waiting_.front().first, waiting_.front().second) > 0)
            waiting_.pop_front();
    }
    void clear() noexcept { waiting_.clear(); }

  private:
    std::deque<std::pair<DatagramPeer, std::vector<std::byte>>> waiting_;
};

}  // namespace afferent
