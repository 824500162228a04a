// Frames: messages on a stream of bytes or in datagrams, with a checksum that is verified before they are
// parsed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "afferent/io/wire/messages.hpp"
#include "afferent/runtime/result.hpp"

namespace afferent {

// The longest message; a frame that claims more is refused before it is read. Packets of the longest layout
// fit.
inline constexpr std::size_t max_message_bytes = std::size_t{256} * 1024;

// The limit of a UDP datagram over IPv4; a serial line has the same.
inline constexpr std::size_t longest_datagram_bytes = 65'507;
// The most that sealing adds to a frame.
inline constexpr std::size_t longest_seal_bytes = 20;
inline constexpr std::size_t max_datagram_frame_bytes = longest_datagram_bytes - longest_seal_bytes;

// On a stream: the message's length as a varint of at most three bytes, the message, its CRC-32C (least
// significant byte first). In a datagram: the same without the length.
class FrameWriter {
  public:
    // The bytes stay valid until the next call. The message must not be longer than max_message_bytes; on a
    // link it is an Envelope, in a recording an Entry.
    std::span<const std::byte> stream_frame(const google::protobuf::MessageLite& message);
    std::span<const std::byte> datagram(const google::protobuf::MessageLite& message);

  private:
    std::span<const std::byte> write(const google::protobuf::MessageLite& message, bool with_length);

    std::vector<std::byte> bytes_;
};

// The size of the frame that begins with these bytes: 0 if they are too few to tell, nothing if no frame
// begins like this.
std::optional<std::size_t> stream_frame_size(std::span<const std::byte> bytes,
                                             std::size_t longest_message = max_message_bytes);

// What has been received since construction.
struct FrameCounts {
    std::uint64_t bytes = 0;
    std::uint64_t frames = 0;             // good ones
    std::uint64_t checksum_failures = 0;  // frames whose bytes were changed on their way
    std::uint64_t refused = 0;  // frames with a good checksum, or a length, that no correct peer sends
    // Datagrams that do not come from the session's peer: they have no other effect than this count.
    std::uint64_t forged = 0;
    // Authentic datagrams that are not newer than the newest so far: doubled, overtaken or replayed.
    std::uint64_t repeated = 0;
};

// Parses a datagram. Its message must be complete, have no unknown field, and be of one kind only.
[[nodiscard]] Result<void> read_datagram(std::span<const std::byte> datagram, proto::Envelope& message,
                                         FrameCounts& counts);

// Parses a stream. Its memory begins with a few kilobytes and grows with the frame that needs more, up to one
// of the longest kind: a peer that says little costs little.
//
//     read into reader.space(), then reader.filled(count);
//     for (;;) { Result<bool> next = reader.next(message); ... }
class FrameReader {
  public:
    explicit FrameReader(std::size_t longest_message = max_message_bytes);

    // Takes the memory for the longest frame now, and no more later.
    void reserve();

    // Where to put the next bytes of the stream. Never empty if next() has been called until it returned
    // false.
    std::span<std::byte> space();
    void filled(std::size_t count) noexcept;

    // True: `message` is the next message. False: more bytes are needed. An error: a frame was dropped, and
    // the next call continues behind it, unless lost(): then the stream cannot be followed any further.
    Result<bool> next(proto::Envelope& message);
    // The same for any message: its bytes, with a good checksum and not looked into. Valid until space().
    Result<bool> next_bytes(std::span<const std::byte>& message);

    bool lost() const noexcept { return lost_; }
    const FrameCounts& counts() const noexcept { return counts_; }

  private:
    std::size_t longest_frame() const noexcept;

    std::size_t longest_message_;
    std::vector<std::byte> bytes_;
    std::size_t begin_ = 0;
    std::size_t end_ = 0;
    bool lost_ = false;
    FrameCounts counts_;
};

}  // namespace afferent
