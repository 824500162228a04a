// The listening end of a sealed datagram link: turns datagrams from anybody into peers that have proven who
// they are.
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

// A peer that has not returned its cookie costs an answer of a few microseconds, and no memory. From then on
// it takes one of a few places for about a second; when all are taken, the oldest handshake makes way.
// Answers are limited for each peer, and handshakes for each address, so that a flood from elsewhere keeps
// nobody out.
class DtlsAcceptor {
  public:
    using Time = std::chrono::steady_clock::time_point;
    using Send = std::function<void(const DatagramPeer&, std::span<const std::byte>)>;
    static constexpr std::size_t most_peers = 16;
    // The limits for one peer, for one address, and for all together.
    static constexpr int cookies_per_second = 500;
    static constexpr int handshakes_per_second = 20;
    static constexpr int most_handshakes_per_second = 200;
    // A cookie is accepted for between one and two of these periods.
    static constexpr std::chrono::seconds cookie_time{8};

    // The same form for IPv4 and IPv6.
    using AddressAndPort = std::array<unsigned char, 16 + 2>;

    // A peer whose handshake is under way or done, and that has no session yet.
    struct Peer {
        DatagramPeer address;
        DtlsRandom random;
        Time until;
        std::unique_ptr<DtlsHandshake> handshake;
        std::optional<DatagramCodec> codec{};  // once its handshake is done
        // The bytes since its first hello, assuming that nothing before its second hello was lost or
        // repeated, because no state is kept until then.
        CarriedBytes carried{};
    };

    DtlsAcceptor(DtlsContext context, const DatagramLine& line, Send send);

    DtlsAcceptor(const DtlsAcceptor&) = delete;
    DtlsAcceptor& operator=(const DtlsAcceptor&) = delete;

    // Takes a datagram for which is_dtls() holds. False: it belongs to no handshake, or there have been too
    // many.
    bool receive(const DatagramPeer& from, std::span<const std::byte> datagram, Time now);
    // The peer that has sealed this datagram, whose content goes to `frame`; null if there is none. The peer
    // is to be removed when it gets a session.
    Peer* peer_of(const DatagramPeer& from, std::span<const std::byte> datagram,
                  std::vector<std::byte>& frame, Time now);
    void remove(const Peer& peer);

    // Repeats flights that were lost, and forgets peers that are too slow. To be called every few
    // milliseconds while there are peers.
    void look_after(Time now);

    std::size_t peers() const noexcept { return peers_.size(); }
    // Peers that have proven their address and then failed to prove who they are.
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
    AddressBudget cookie_budget_{cookies_per_second};
    AddressBudget handshake_budget_{handshakes_per_second};
    RateLimit handshake_rate_{most_handshakes_per_second, most_handshakes_per_second};
    // Where the handshake that is called at present sends to.
    struct Recipient {
        DatagramPeer address;
        CarriedBytes* carried = nullptr;  // where it is counted
    } recipient_;
    std::unique_ptr<DtlsHandshake>
        door_;               // the next peer's handshake: it has no state until listen() succeeds
    std::list<Peer> peers_;  // oldest first
    std::uint64_t refused_ = 0;
};

}  // namespace afferent
