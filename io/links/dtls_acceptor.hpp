// The end of a sealed datagram link that listens: from anybody's datagrams to peers that have proven who they
// are.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "afferent/io/links/datagram_port.hpp"
#include "afferent/io/links/dtls.hpp"
#include "afferent/io/links/rate_limit.hpp"

namespace afferent {

// A peer that has not returned its cookie costs an answer, and nothing is kept of it. From then on it takes
// one of a few places for a second or so; the oldest handshake gives way to another. How many cookies are
// answered and how many handshakes begun in a second is limited, whoever asks.
class DtlsAcceptor {
  public:
    using Time = std::chrono::steady_clock::time_point;
    using Send = std::function<void(const DatagramPeer&, std::span<const std::byte>)>;
    static constexpr std::size_t most_peers = 16;
    static constexpr int cookies_per_second = 500;
    static constexpr int handshakes_per_second = 20;
    // A cookie is accepted for one to two of these.
    static constexpr std::chrono::seconds cookie_time{8};

    // A peer that has its handshake under way or behind it, and no session yet.
    struct Peer {
        DatagramPeer address;
        DtlsRandom random;
        Time until;
        std::unique_ptr<DtlsHandshake> handshake;
        std::optional<DatagramCodec> codec{};  // once its handshake is done
        // Since its first hello, as if nothing before its second had been lost or repeated: of that nothing
        // is kept.
        CarriedBytes carried{};
    };

    DtlsAcceptor(DtlsContext context, const DatagramLine& line, Send send);

    DtlsAcceptor(const DtlsAcceptor&) = delete;
    DtlsAcceptor& operator=(const DtlsAcceptor&) = delete;

    // A datagram for which is_dtls() holds. False: it is nobody's, or there have been too many.
    bool receive(const DatagramPeer& from, std::span<const std::byte> datagram, Time now);
    // The peer that has sealed this datagram, and what it holds. To be removed when it gets a session.
    Peer* peer_of(const DatagramPeer& from, std::span<const std::byte> datagram,
                  std::vector<std::byte>& frame, Time now);
    void remove(const Peer& peer);

    // Repeats what is lost and forgets who is late. To be called every few milliseconds while there are
    // peers.
    void look_after(Time now);

    std::size_t peers() const noexcept { return peers_.size(); }
    // Peers that have proven their address and nothing else.
    std::uint64_t refused() const noexcept { return refused_; }

  private:
    bool greet(const DatagramPeer& from, std::span<const std::byte> datagram, const DtlsRandom& random,
               Time now);
    void send(std::span<const std::byte> datagram);
    void make_room();
    // False: the handshake has failed.
    bool settle(Peer& peer, Time now);
    DtlsCookies cookies(const DatagramPeer& of, Time now) const;

    DtlsContext context_;
    DatagramLine line_;
    Send send_;
    SecretKey cookie_secret_ = SecretKey::generate();
    RateLimit cookie_rate_{cookies_per_second, cookies_per_second};
    RateLimit handshake_rate_{handshakes_per_second, handshakes_per_second};
    // Of what the handshake that is called sends.
    struct Recipient {
        DatagramPeer address;
        CarriedBytes* carried = nullptr;  // where it is counted
    } recipient_;
    std::unique_ptr<DtlsHandshake> door_;  // remembers nobody, until it is the next peer's handshake
    std::list<Peer> peers_;                // the oldest first
    std::uint64_t refused_ = 0;
};

}  // namespace afferent
