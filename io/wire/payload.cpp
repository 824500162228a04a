#include "afferent/io/wire/payload.hpp"

#include <algorithm>
#include <bit>
#include <boost/endian/conversion.hpp>
#include <cassert>
#include <cmath>
#include <cstring>
#include <functional>

#include "afferent/io/wire/spike_predictor.hpp"

namespace afferent {
namespace {

constexpr std::uint32_t max_parameter = 31;

// Bits that a window is sure to hold behind the position it was read at.
constexpr std::uint32_t window_bits = 57;

Error malformed(const char* text) { return {Error::Kind::malformed, std::string("payload: ") + text}; }

// Bits into bytes, from the least significant of each. Writes up to 8 bytes beyond the last bit.
class BitWriter {
  public:
    explicit BitWriter(char* out) noexcept : out_(reinterpret_cast<unsigned char*>(out)) {}

    // At most 56 bits; those of `bits` above must be 0.
    void put(std::uint64_t bits, std::uint32_t count) noexcept {
        pending_ |= bits << used_;
        used_ += count;
        boost::endian::store_little_u64(out_, pending_);
        out_ += used_ / 8;
        pending_ >>= used_ & ~7U;
        used_ &= 7U;
    }

  private:
    unsigned char* out_;
    std::uint64_t pending_ = 0;
    std::uint32_t used_ = 0;
};

// Bits out of bytes; zeros behind the last.
class BitReader {
  public:
    explicit BitReader(std::span<const std::byte> bytes) noexcept : bytes_(bytes) {}

    std::uint64_t bits() const noexcept { return std::uint64_t{bytes_.size()} * 8; }

    // The next bits, at least window_bits of them.
    std::uint64_t window(std::uint64_t position) const noexcept {
        const std::uint64_t byte = position / 8;
        return load(byte) >> (position & 7);
    }

  private:
    std::uint64_t load(std::uint64_t byte) const noexcept {
        const auto* data = reinterpret_cast<const unsigned char*>(bytes_.data());
        if (byte + 8 <= bytes_.size()) [[likely]]
            return boost::endian::load_little_u64(data + byte);
        unsigned char last[8] = {};
        if (byte < bytes_.size()) std::memcpy(last, data + byte, bytes_.size() - byte);
        return boost::endian::load_little_u64(last);
    }

    std::span<const std::byte> bytes_;
};

// The sum of all gaps is the last code, so that no sum of theirs needs more than 32 bits.
std::uint32_t unary_bits(std::span<const Code> gaps, std::uint32_t parameter) noexcept {
    std::uint32_t sum = 0;
    for (const Code gap : gaps) sum += gap >> parameter;
    return sum;
}

std::uint64_t rice_bits(std::span<const Code> gaps, std::uint32_t parameter) noexcept {
    return unary_bits(gaps, parameter) + std::uint64_t{gaps.size()} * (parameter + 1);
}

struct Choice {
    std::uint32_t parameter;
    std::uint64_t bits;
};

// The number of bits is convex in the parameter but for the rounding of shifts: down the slope from a good
// guess.
Choice best_parameter(std::span<const Code> gaps, std::uint32_t guess) noexcept {
    Choice best{guess, rice_bits(gaps, guess)};
    while (best.parameter < max_parameter) {
        const Choice next{best.parameter + 1, rice_bits(gaps, best.parameter + 1)};
        if (next.bits >= best.bits) break;
        best = next;
    }
    if (best.parameter != guess) return best;
    while (best.parameter > 0) {
        const Choice next{best.parameter - 1, rice_bits(gaps, best.parameter - 1)};
        if (next.bits >= best.bits) break;
        best = next;
    }
    return best;
}

}  // namespace

PayloadCodec::PayloadCodec(const PacketLayout& layout)
    : encoding_(layout.encoding),
      span_codes_(layout.span_codes()),
      codes_(layout.codes()),
      max_events_(layout.max_events) {
    layout.check();
    const auto code_bits = static_cast<std::uint32_t>(std::bit_width(codes_ - 1));
    width_ = std::max(1U, (code_bits + 7) / 8);
    scratch_.resize(max_events_);
}

// Rice codes: n gaps that add up to less than all codes take n (k + 1) bits and codes / 2^k more. The
// parameter that is implied is log2(c / n), with c = 77/80 codes, rounded down: that makes less than n
// (log2(c / n) + 2.1) bits. Where n > c it is 0, which makes n + codes, and 1.1 codes so that it begins above
// the other. Both rise with n, up to max_events.
std::size_t PayloadCodec::most_bytes(const PacketLayout& layout) {
    if (layout.encoding == Encoding::fixed_width)
        return std::size_t{layout.max_events} * PayloadCodec(layout).width_;
    const double n = layout.max_events;
    if (layout.encoding == Encoding::predicted) return SpikePredictor::most_bytes(layout);
    const auto codes = static_cast<double>(layout.codes());
    const double c = 77.0 / 80.0 * codes;
    const double bits = n > c ? n + 1.1 * codes : n * (std::log2(c / n) + 2.1);
    constexpr std::size_t header_bytes = 4;
    return header_bytes + static_cast<std::size_t>(bits / 8) + 1;
}

void PayloadCodec::encode(std::span<const Code> codes, std::string& payload, std::uint32_t spans) {
    codes_ = spans * span_codes_;
    assert(codes.size() <= max_events_);
    assert(std::is_sorted(codes.begin(), codes.end()));
    assert(codes.empty() || codes.back() < codes_);
    if (codes.empty())
        payload.clear();
    else if (encoding_ == Encoding::fixed_width)
        encode_fixed_width(codes, payload);
    else
        encode_rice(codes, payload);
}

Result<std::span<const Code>> PayloadCodec::decode(std::span<const std::byte> payload, std::uint32_t spans) {
    codes_ = spans * span_codes_;
    if (payload.empty()) return std::span<const Code>();
    AFFERENT_TRY(events,
                 encoding_ == Encoding::fixed_width ? decode_fixed_width(payload) : decode_rice(payload));
    return std::span<const Code>(scratch_).first(events);
}

// The optimal parameter for geometric gaps of mean m is floor(log2(m ln(1/(φ − 1)))) + 1, φ the golden ratio
// (Kiely, JPL IPN Progress Report 42-159, 2004); 2 ln(1/(φ − 1)) is 77/80 to four digits, and both ends must
// round alike.
std::uint32_t PayloadCodec::implied_parameter(std::size_t events) const noexcept {
    const std::uint64_t scaled = 77 * codes_ / (80 * std::uint64_t{events});
    return scaled == 0 ? 0 : std::min(max_parameter, static_cast<std::uint32_t>(std::bit_width(scaled)) - 1);
}

void PayloadCodec::encode_rice(std::span<const Code> codes, std::string& payload) {
    const std::span<Code> gaps = std::span(scratch_).first(codes.size());
    gaps[0] = codes[0];
    std::transform(codes.begin() + 1, codes.end(), codes.begin(), gaps.begin() + 1, std::minus<>());

    const std::uint32_t implied = implied_parameter(codes.size());
    Choice choice = best_parameter(gaps, implied);
    if (choice.parameter != implied) {
        const Choice without{implied, rice_bits(gaps, implied)};
        if (without.bits <= choice.bits + 8) choice = without;
    }
    const std::uint32_t k = choice.parameter;

    // The header as a varint of up to three bytes and the parameter's byte; the writer needs 8 bytes to
    // spare.
    payload.resize(4 + (choice.bits + 7) / 8 + 8);
    char* out = payload.data();
    auto head = static_cast<std::uint32_t>(2 * codes.size() + (k != implied ? 1 : 0));
    for (; head >= 0x80; head >>= 7) *out++ = static_cast<char>(head | 0x80);
    *out++ = static_cast<char>(head);
    if (k != implied) *out++ = static_cast<char>(k);

    BitWriter bits(out);
    const std::uint32_t mask = (1U << k) - 1;
    for (const Code gap : gaps) {
        std::uint32_t zeros = gap >> k;
        while (zeros + 1 + k > 56) [[unlikely]] {
                const std::uint32_t some = std::min(zeros, 56U);
                bits.put(0, some);
                zeros -= some;
            }
        bits.put(((std::uint64_t{gap & mask} << 1) | 1) << zeros, zeros + 1 + k);
    }
    payload.resize(static_cast<std::size_t>(out - payload.data()) + (choice.bits + 7) / 8);
}

Result<std::size_t> PayloadCodec::decode_rice(std::span<const std::byte> payload) {
    std::uint32_t head = 0;
    std::size_t read = 0;
    for (std::uint32_t shift = 0;; shift += 7) {
        if (read == payload.size()) return malformed("ends within its header");
        if (shift > 14) return malformed("claims more events than any packet holds");
        const auto byte = std::to_integer<std::uint32_t>(payload[read++]);
        head |= (byte & 0x7f) << shift;
        if (byte < 0x80) break;
    }
    const std::uint32_t events = head / 2;
    if (events == 0) return malformed("claims no events, but is not empty");
    if (events > max_events_) return malformed("claims more events than the session allows");
    std::uint32_t k = implied_parameter(events);
    if (head % 2 != 0) {
        if (read == payload.size()) return malformed("ends within its header");
        k = std::to_integer<std::uint32_t>(payload[read++]);
        if (k > max_parameter) return malformed("has no such Rice parameter");
    }
    const BitReader bits(payload.subspan(read));
    if (std::uint64_t{events} * (k + 1) > bits.bits())
        return malformed("is shorter than the events it claims");

    const std::uint64_t mask = (std::uint64_t{1} << k) - 1;
    std::uint64_t position = 0;
    // Cannot overflow: a gap that is not checked at once is below 2^37.
    std::uint64_t code = 0;
    std::uint32_t i = 0;
    while (i < events) {
        const std::uint64_t window = bits.window(position);
        const auto zeros = static_cast<std::uint32_t>(std::countr_zero(window));
        const std::uint32_t length = zeros + 1 + k;
        if (length <= window_bits) [[likely]] {
            const std::uint64_t tail = window >> zeros >> 1;
            code += (std::uint64_t{zeros} << k) + (tail & mask);
            position += length;
            scratch_[i++] = static_cast<Code>(code);
            // Most often the window holds the next gap as well: reading it there costs no second load.
            const std::uint64_t rest = tail >> k;
            const auto next_zeros = static_cast<std::uint32_t>(std::countr_zero(rest));
            const std::uint32_t next_length = next_zeros + 1 + k;
            if (length + next_length <= window_bits && i < events) {
                code += (std::uint64_t{next_zeros} << k) + ((rest >> next_zeros >> 1) & mask);
                position += next_length;
                scratch_[i++] = static_cast<Code>(code);
            }
            continue;
        }
        // A gap too long for one window.
        std::uint64_t run = 0;
        while (bits.window(position) << (64 - window_bits) == 0) {
            run += window_bits;
            position += window_bits;
            if (position >= bits.bits()) return malformed("ends within a gap");
        }
        const auto more = static_cast<std::uint32_t>(std::countr_zero(bits.window(position)));
        run += more;
        position += more + 1;
        if (run > codes_ >> k) return malformed("has an event beyond its span");
        code += (run << k) + (bits.window(position) & mask);
        position += k;
        scratch_[i++] = static_cast<Code>(code);
    }
    if (code >= codes_) return malformed("has an event beyond its span");
    if (position > bits.bits()) return malformed("is shorter than the events it claims");
    if (bits.bits() - position >= 8) return malformed("has bytes behind its last event");
    // Zeros come from behind the end as well, so only the bits that are there count.
    if (bits.window(position) != 0) return malformed("has bits behind its last event");
    return events;
}

void PayloadCodec::encode_fixed_width(std::span<const Code> codes, std::string& payload) const {
    payload.resize(codes.size() * width_);
    char* out = payload.data();
    for (Code code : codes)
        for (std::uint32_t i = 0; i < width_; ++i, code >>= 8) *out++ = static_cast<char>(code);
}

Result<std::size_t> PayloadCodec::decode_fixed_width(std::span<const std::byte> payload) {
    if (payload.size() % width_ != 0) return malformed("is not a whole number of codes");
    const std::size_t events = payload.size() / width_;
    if (events > max_events_) return malformed("has more events than the session allows");
    for (std::size_t i = 0; i < events; ++i) {
        std::uint32_t code = 0;
        for (std::uint32_t b = 0; b < width_; ++b)
            code |= std::to_integer<std::uint32_t>(payload[i * width_ + b]) << (8 * b);
        if (code >= codes_) return malformed("has an event beyond its span");
        if (i > 0 && code < scratch_[i - 1]) return malformed("has events out of order");
        scratch_[i] = code;
    }
    return events;
}

}  // namespace afferent
