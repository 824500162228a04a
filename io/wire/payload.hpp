// The payload of a packet: its events, near the entropy of where and when they happened.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "afferent/io/wire/packet_layout.hpp"
#include "afferent/runtime/result.hpp"

namespace afferent {

// tick · addresses + address, the tick counted from the begin of the first span that may hold events.
using Code = std::uint32_t;

// Codes in, bytes out, and back. The bytes are described in aer.proto.
//
// Spikes of many independent neurons are close to a Poisson process, and the gaps of its codes are geometric:
// Rice codes (Rice and Plaunt 1971) are optimal for them to within 3 %, and to within 1 % where the parameter
// may be chosen. It follows from the number of events for such a process; where spikes come in volleys
// another costs one byte more, and is taken if it saves more than that.
class PayloadCodec {
  public:
    explicit PayloadCodec(const PacketLayout& layout);

    // No payload of this layout is longer.
    static std::size_t most_bytes(const PacketLayout& layout);
    // The bytes of one code in FIXED_WIDTH.
    std::uint32_t code_bytes() const noexcept { return width_; }

    // `spans` is how many may hold events, from 1 to layout.gathered_spans. Codes must not decrease, must be
    // below spans · layout.span_codes(), and at most layout.max_events. No codes, no bytes. Allocates only
    // where `payload` has never been as long before.
    void encode(std::span<const Code> codes, std::string& payload, std::uint32_t spans = 1);

    // The codes stay valid until the next call. Whatever encode() cannot have written is refused, as
    // `malformed`.
    Result<std::span<const Code>> decode(std::span<const std::byte> payload, std::uint32_t spans = 1);

  private:
    std::uint32_t implied_parameter(std::size_t events) const noexcept;
    void encode_rice(std::span<const Code> codes, std::string& payload);
    void encode_fixed_width(std::span<const Code> codes, std::string& payload) const;
    Result<std::size_t> decode_rice(std::span<const std::byte> payload);
    Result<std::size_t> decode_fixed_width(std::span<const std::byte> payload);

    Encoding encoding_;
    std::uint64_t span_codes_;
    std::uint64_t codes_;  // how many there are in the packet at hand
    std::uint32_t max_events_;
    std::uint32_t width_;        // of a code, in bytes, in the fixed-width encoding
    std::vector<Code> scratch_;  // the gaps of the packet to encode, or the codes of the packet just decoded
};

}  // namespace afferent
