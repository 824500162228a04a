// Range coding: symbols into bytes at the entropy of the frequencies that both ends know, in integers alone.
#pragma once

#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace afferent {

// A symbol takes the part [low, low + frequency) of `total`. 18 bits leave the coder at least 6 of precision.
inline constexpr std::uint32_t most_total = std::uint32_t{1} << 18;

// After Martin (Video & Data Recording Conference, Southampton 1979), with carries handed on to the bytes
// already written. Each payload is one message: it begins with the full range and ends with as few bytes as
// tell it from every other, zeros at the end left out.
class RangeEncoder {
  public:
    explicit RangeEncoder(std::string& out) : out_(out) { out_.clear(); }

    void put(std::uint32_t low, std::uint32_t frequency, std::uint32_t total) {
        assert(frequency > 0 && low + frequency <= total && total <= most_total);
        const std::uint32_t unit = range_ / total;
        low_ += std::uint64_t{unit} * low;
        range_ = unit * frequency;
        while (range_ < std::uint32_t{1} << 24) {
            shift();
            range_ <<= 8;
        }
    }

    // Equally likely values below 2^bits, bits <= 18.
    void put_bits(std::uint32_t value, std::uint32_t bits) { put(value, 1, std::uint32_t{1} << bits); }

    // What the symbols so far take, in whole and part bits; to be asked before finish().
    double bits() const { return 8.0 * static_cast<double>(out_.size()) + 32 - std::log2(range_); }

    void finish() {
        // The number within the range with the most zeros at its end.
        const std::uint64_t last = low_ + range_ - 1;
        std::uint32_t zeros = 32;
        while ((last >> zeros << zeros) < low_) --zeros;
        low_ = last >> zeros << zeros;
        for (int byte = 0; byte < 4; ++byte) shift();
        while (!out_.empty() && out_.back() == 0) out_.pop_back();
    }

  private:
    void shift() {
        if (low_ >> 32 != 0)
            for (std::size_t at = out_.size(); ++out_[--at] == 0;) continue;
        out_.push_back(static_cast<char>(low_ >> 24 & 0xff));
        low_ = (low_ & 0xff'ffff) << 8;
    }

    std::string& out_;
    std::uint64_t low_ = 0;
    std::uint32_t range_ = 0xffff'ffff;
};

class RangeDecoder {
  public:
    // Zeros follow the last byte.
    explicit RangeDecoder(std::span<const std::byte> bytes) noexcept : bytes_(bytes) {
        for (int byte = 0; byte < 4; ++byte) code_ = code_ << 8 | next();
    }

    // Where in `total` the next symbol lies; to be followed by take() of that symbol.
    std::uint32_t find(std::uint32_t total) noexcept {
        unit_ = range_ / total;
        const std::uint32_t found = code_ / unit_;
        return found < total ? found : total - 1;
    }

    void take(std::uint32_t low, std::uint32_t frequency) noexcept {
        code_ -= unit_ * low;
        range_ = unit_ * frequency;
        while (range_ < std::uint32_t{1} << 24) {
            code_ = code_ << 8 | next();
            range_ <<= 8;
        }
    }

    std::uint32_t take_bits(std::uint32_t bits) noexcept {
        const std::uint32_t value = find(std::uint32_t{1} << bits);
        take(value, 1);
        return value;
    }

    // No encoder writes more bytes than the symbols taken have asked for.
    bool used_all() const noexcept { return position_ >= bytes_.size(); }

  private:
    std::uint32_t next() noexcept {
        const std::size_t at = position_++;
        return at < bytes_.size() ? std::to_integer<std::uint32_t>(bytes_[at]) : 0;
    }

    std::span<const std::byte> bytes_;
    std::size_t position_ = 0;
    std::uint32_t code_ = 0;
    std::uint32_t range_ = 0xffff'ffff;
    std::uint32_t unit_ = 1;
};

}  // namespace afferent
