// From frames to datagrams and back, plain or sealed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "afferent/io/links/secret_key.hpp"

namespace afferent {

// The first byte of a datagram. No frame begins with any of them.
enum class DatagramKind : std::uint8_t { request = 1, reply = 2, data = 3 };

// One end of one session. An empty frame is a sign of life.
//
// Plain: the frame as it is; an empty frame is the byte of the kind `data`. Every datagram of one byte is
// read as an empty frame, for instance a second reply. Sealed: the kind `data`, a counter as a varint, the
// encrypted frame, a tag of 16 bytes. ChaCha20-Poly1305 (RFC 8439) with a key for each direction of each
// session. The counter is the nonce; it begins at 1 and rises with every datagram. The tag covers kind and
// counter too. The frame keeps its checksum.
class DatagramCodec {
  public:
    // Plain.
    DatagramCodec() = default;
    DatagramCodec(const SecretKey& sending, const SecretKey& receiving)
        : keys_(Keys{.sending = sending, .receiving = receiving}) {}

    void wrap(std::span<const std::byte> frame, std::vector<std::byte>& datagram);

    enum class Unwrapped {
        good,
        repeated,  // authentic, but not newer than the newest so far: doubled, overtaken or replayed
        forged,    // not made with this session's keys
    };
    Unwrapped unwrap(std::span<const std::byte> datagram, std::vector<std::byte>& frame);

    bool sealed() const noexcept { return keys_.has_value(); }

  private:
    struct Keys {
        SecretKey sending;
        SecretKey receiving;
    };

    std::optional<Keys> keys_;
    std::uint64_t sent_ = 0;
    std::uint64_t newest_ = 0;
};

}  // namespace afferent
