// How the two ends of a datagram link find out that the other is there, and who it is.
//
//     initiator → responder    request
//     responder → initiator    reply
//     initiator → responder    data: only now does the responder believe that a peer is there
//
// The connector initiates, the listener responds. Plain, request and reply are the byte of their kind, and
// the first data is a hello. Sealed, each is
//
//     kind, nonce of 24 random bytes, tag of 16 bytes (XChaCha20-Poly1305 of nothing)
//
// under a key derived from the shared one; the tag of a reply covers the nonce of its request too. Both
// nonces and the shared key give the keys of the session, one for each direction. A replayed request gets a
// reply, and its sender cannot go on from there.
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

class Initiator {
  public:
    // Has a new nonce at every construction. Plain without a key.
    explicit Initiator(const std::optional<SecretKey>& key);

    // May be sent any number of times.
    std::span<const std::byte> request() const noexcept { return request_; }

    // The codec of the session, if this is the reply.
    std::optional<DatagramCodec> answered_by(std::span<const std::byte> datagram) const;

  private:
    std::optional<SecretKey> key_;
    HandshakeNonce nonce_{};
    std::vector<std::byte> request_;
};

class Responder {
  public:
    // How many handshakes may be under way; the oldest gives way to another. Repeating a request begins none.
    static constexpr std::size_t most_waiting = 8;
    // When a request is forgotten. All are when a peer is accepted, so that first data that somebody has held
    // back opens no session later.
    static constexpr std::chrono::seconds longest_wait{5};
    using Time = std::chrono::steady_clock::time_point;

    explicit Responder(const std::optional<SecretKey>& key) : key_(key) {}

    // What to send back, if this is a request.
    std::optional<std::vector<std::byte>> reply(std::span<const std::byte> datagram, Time now);

    // The codec of the session and the first frame, if this datagram opens a session.
    struct Accepted {
        Accepted(const DatagramCodec& codec_in, std::vector<std::byte> frame_in)
            : codec(codec_in), frame(std::move(frame_in)) {}

        DatagramCodec codec;
        std::vector<std::byte> frame;
    };
    std::optional<Accepted> accept(std::span<const std::byte> datagram, Time now);

    bool sealed() const noexcept { return key_.has_value(); }

  private:
    struct Waiting {
        HandshakeNonce request;
        Time since;
        std::vector<std::byte> reply;
        DatagramCodec codec;
    };

    void forget_old(Time now);

    std::optional<SecretKey> key_;
    std::deque<Waiting> waiting_;
};

}  // namespace afferent
