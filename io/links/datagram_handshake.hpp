// How the two ends of a datagram link find out that the other is there, and who it is.
//
//     connector → listener    knock
//     listener → connector    reply
//     connector → listener    data: the listener believes that somebody is there, from here on
//
// Plain, knock and reply are their kind's byte and no more, and the first data is a hello. Sealed, each is
//
//     kind, nonce of 24 random bytes, tag of 16 bytes (XChaCha20-Poly1305 of nothing)
//
// under a key that follows from the shared one; the reply's tag covers the knock's nonce as well. Both nonces
// and the shared key give the keys of the session, one for each direction. Who replays a knock gets a reply,
// and cannot go on from there.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "afferent/io/links/datagram_codec.hpp"
#include "afferent/io/links/secret_key.hpp"

namespace afferent {

inline constexpr std::size_t handshake_nonce_bytes = 24;
using HandshakeNonce = std::array<unsigned char, handshake_nonce_bytes>;

// The connector's part.
class Knock {
  public:
    // New at every construction. Plain without a key.
    explicit Knock(const std::optional<SecretKey>& key);

    // May be sent any number of times.
    std::span<const std::byte> datagram() const noexcept { return datagram_; }

    // What the session is carried by, if this is the reply.
    std::optional<DatagramCodec> answered_by(std::span<const std::byte> datagram) const;

  private:
    std::optional<SecretKey> key_;
    HandshakeNonce nonce_{};
    std::vector<std::byte> datagram_;
};

// The listener's part.
class Door {
  public:
    // Handshakes under way, at most: the oldest gives way. The same knock is always one.
    static constexpr std::size_t most_waiting = 8;
    // Then a knock is forgotten, and so are all where one has come in: first data that somebody has kept back
    // opens nothing later.
    static constexpr std::chrono::seconds longest_wait{5};
    using Time = std::chrono::steady_clock::time_point;

    explicit Door(const std::optional<SecretKey>& key) : key_(key) {}

    // What to send back, if this is a knock.
    std::optional<std::vector<std::byte>> reply(std::span<const std::byte> datagram, Time now);

    // Who has come in, with the first frame.
    struct Entry {
        DatagramCodec codec;
        std::vector<std::byte> frame;
    };
    std::optional<Entry> entry(std::span<const std::byte> datagram, Time now);

    bool sealed() const noexcept { return key_.has_value(); }

  private:
    struct Waiting {
        HandshakeNonce knock;
        Time since;
        std::vector<std::byte> reply;
        DatagramCodec codec;
    };

    void forget_old(Time now);

    std::optional<SecretKey> key_;
    std::deque<Waiting> waiting_;
};

}  // namespace afferent
