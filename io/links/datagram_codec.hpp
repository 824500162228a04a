// From frames to datagrams and back, plain or sealed.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "afferent/io/links/key_chain.hpp"
#include "afferent/io/links/replay_window.hpp"
#include "afferent/io/links/secret_key.hpp"

namespace afferent {

// The first byte of a datagram on a plain link that is not a frame; no frame begins with any of these.
// `keyed` is the answer of a listener with keys to a request.
enum class DatagramKind : std::uint8_t { request = 1, reply = 2, data = 3, keyed = 4 };

constexpr std::byte byte_of(DatagramKind kind) { return std::byte(static_cast<std::uint8_t>(kind)); }
inline bool is_plain(std::span<const std::byte> datagram, DatagramKind kind) {
    return datagram.size() == 1 && datagram[0] == byte_of(kind);
}

// One end of one session. An empty frame is a sign of life.
//
// Plain: the frame as it is; an empty frame is the byte `data`. Every datagram of one byte, such as a second
// reply, is read as an empty frame.
//
// Sealed: a byte, 64 + the number of the key modulo 64; a counter as a varint; the encrypted frame; a tag of
// 16 bytes. ChaCha20-Poly1305 (RFC 8439), with separate keys for each direction. The counter is the nonce; it
// begins at 1 with every key. The tag covers the bytes before it. The frame keeps its checksum. A sender
// takes the next key of its chain when a key has sealed 2^20 datagrams or is two minutes old; the receiver
// follows at the first datagram under the new key, and forgets the old one two seconds later.
class DatagramCodec {
  public:
    using Time = std::chrono::steady_clock::time_point;
    static constexpr std::uint64_t most_datagrams_of_a_key = std::uint64_t{1} << 20;
    static constexpr std::chrono::seconds longest_use_of_a_key{120};
    static constexpr std::chrono::seconds grace_of_a_key{2};

    // Plain.
    DatagramCodec() = default;
    // The secrets are those of the handshake.
    DatagramCodec(const SecretKey& sending, const SecretKey& receiving, Time now);

    void wrap(std::span<const std::byte> frame, std::vector<std::byte>& datagram, Time now);

    enum class Unwrapped {
        good,
        overtaken,  // as good, but newer ones have come before it
        repeated,   // doubled or replayed, or so old that nobody can tell; its tag is not verified
        forged,     // not made with this session's keys
    };
    Unwrapped unwrap(std::span<const std::byte> datagram, std::vector<std::byte>& frame, Time now);

    friend bool is_taken(Unwrapped how) noexcept {
        return how == Unwrapped::good || how == Unwrapped::overtaken;
    }

    bool sealed() const noexcept { return sender_.has_value(); }

  private:
    struct Sender {
        Sender(const SecretKey& secret, Time now) : chain(secret), key(chain.next_key()), since(now) {}

        KeyChain chain;
        SecretKey key;
        unsigned number = 0;
        std::uint64_t sent = 0;
        Time since;
    };
    struct Period {
        SecretKey key;
        ReplayWindow window{};
    };
    struct Receiver {
        explicit Receiver(const SecretKey& secret)
            : chain(secret), current{chain.next_key()}, next{chain.next_key()} {}

        Period* period(unsigned key_number);
        void renew(Time now);

        KeyChain chain;
        std::optional<Period> previous{};
        Period current;
        Period next;
        unsigned number = 0;  // of the current key
        Time since{};
    };

    std::optional<Sender> sender_;
    std::optional<Receiver> receiver_;
};

}  // namespace afferent
