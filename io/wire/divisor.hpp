// Division by a number that is fixed for a session, as a multiplication.
#pragma once

#include <cassert>
#include <cstdint>
#include <limits>

namespace afferent {

// With m = floor((2^64 − 1)/d), floor((n + 1) m / 2^64) is floor(n/d) for all 32-bit n and d > 0: the error
// of m is at most d/2^64 of it, and (n + 1) d <= 2^64. (Granlund and Montgomery, PLDI 1994; the rounding is
// Robison's, ARITH 2005.)
class Divisor {
  public:
    explicit Divisor(std::uint32_t divisor) noexcept
        : divisor_(divisor), multiplier_(std::numeric_limits<std::uint64_t>::max() / divisor) {
        assert(divisor > 0);
    }

    std::uint32_t quotient(std::uint32_t dividend) const noexcept {
        __extension__ using Product = unsigned __int128;
        return static_cast<std::uint32_t>((Product{multiplier_} * (std::uint64_t{dividend} + 1)) >> 64);
    }

    std::uint32_t value() const noexcept { return divisor_; }

  private:
    std::uint32_t divisor_;
    std::uint64_t multiplier_;
};

}  // namespace afferent
