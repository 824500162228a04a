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

// One side of one session. An empty frame is a sign of life.
//
// Plain: the frame as it is; an empty one is the kind `data`. Whatever is of one byte is read as an empty
// one: a second reply, say. Sealed: kind `data`, the counter as a varint, the frame encrypted, a tag of 16
// bytes. ChaCha20-Poly1305 (RFC 8439) with a key for each direction of each session; the counter is the
// nonce, begins at 1 and rises with every datagram; what stands before the frame is authenticated with it.
// The frame keeps its checksum.
class DatagramCodec {
  public:
    // Plain.
    DatagramCodec() = default;
    DatagramCodec(const SecretKey& sending, const SecretKey& receiving)
        : keys_(Keys{.sending = sending, .receiving = receiving}) {}

    void wrap(std::span<const std::byte> frame, std::vector<std::byte>& datagram);

    enum class Unwrapped {
        good,
        repeated,  // authentic, but not newer than the newest before it: twice, overtaken, or replayed
        forged,    // by nobody who has this session's keys
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
