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

#include "afferent/io/links/address_budget.hpp"
#include "afferent/io/links/datagram_port.hpp"
#include "afferent/io/links/dtls.hpp"

namespace afferent {

// A peer that has not returned its cookie costs an answer of a few microseconds, and nothing is kept of it.
// From then on it takes one of a few places for a second or so; the oldest handshake gives way to another. A
// peer is answered so often in a second, and an address may begin so many handshakes: a flood from elsewhere
// keeps nobody out.
class DtlsAcceptor {
  public:
    using Time = std::chrono::steady_clock::time_point;
    using Send = std::function<void(const DatagramPeer&, std::span<const std::byte>)>;
    static constexpr std::size_t most_peers = 16;
    // Of one peer; of one address; of all.
    static constexpr int cookies_per_second = 500;
    static constexpr int handshakes_per_second = 20;
    static constexpr int most_handshakes_per_second = 200;
    // A cookie is accepted for one to two of these.
    static constexpr std::chrono::seconds cookie_time{8};

    // In one form for IPv4 and IPv6.
    using AddressAndPort = std::array<unsigned char, 16 + 2>;

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
    bool greet(const DatagramPeer& from, std::span<const std::byte> datagram, const ClientHello& hello,
               Time now);
    void send(std::span<const std::byte> datagram);
    void make_room();
    // False: the handshake has failed.
    bool settle(Peer& peer, Time now);
    DtlsCookies cookies(const AddressAndPort& of, Time now) const;

    DtlsContext context_;
    DatagramLine line_;
    Send send_;
    SecretKey cookie_secret_ = SecretKey::generate();
    AddressBudget cookie_budget_{cookies_per_second, cookies_per_second};
    AddressBudget handshake_budget_{handshakes_per_second, handshakes_per_second};
    RateLimit handshake_rate_{most_handshakes_per_second, most_handshakes_per_second};
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
