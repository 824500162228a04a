// How late the steps of a hand ran: quantiles from a histogram of fixed size.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cstdint>

#include "afferent/runtime/time.hpp"

namespace afferent {

class StepLateness {
  public:
    // A step that is early counts as on time.
    void add(Duration late) noexcept {
        max_ = std::max(max_, late);
        ++buckets_[bucket(late)];
        ++count_;
    }

    // At most a sixteenth above the true quantile, and 1/16 us; never above the largest.
    Duration quantile(double share) const noexcept {
        const auto wanted = static_cast<std::uint64_t>(share * static_cast<double>(count_));
        std::uint64_t seen = 0;
        for (std::size_t i = 0; i < buckets_.size(); ++i)
            if ((seen += buckets_[i]) > wanted) return std::min(upper(i), max_);
        return max_;
    }
    Duration max() const noexcept { return max_; }
    std::uint64_t count() const noexcept { return count_; }

  private:
    // Sixteen buckets for each doubling, from units of 64 ns up to more than an hour.
    static constexpr Duration unit{64};
    static constexpr unsigned bits = 4;
    static constexpr unsigned doublings = 32;

    static std::size_t bucket(Duration late) noexcept {
        const auto units = static_cast<std::uint64_t>(std::max(late, Duration::zero()) / unit);
        const auto width = static_cast<unsigned>(std::bit_width(units));
        if (width <= bits) return units;
        const unsigned shift = width - bits - 1;
        const std::size_t found = (std::size_t{shift} << bits) + (units >> shift);
        return std::min(found, (std::size_t{doublings} << bits) - 1);
    }
    static Duration upper(std::size_t i) noexcept {
        const std::size_t shift = i < (2U << bits) ? 0 : (i >> bits) - 1;
        return unit * static_cast<std::int64_t>((i - (shift << bits) + 1) << shift);
    }

    std::array<std::uint64_t, std::size_t{doublings} << bits> buckets_{};
    std::uint64_t count_ = 0;
    Duration max_{};
};

}  // namespace afferent
