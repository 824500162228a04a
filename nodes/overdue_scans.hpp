// Samples that a coprocessor behind the clock does not give to its neurons: of each element only the newest
// is kept.
#pragma once

#include <cstdint>
#include <vector>

#include "afferent/runtime/scan.hpp"

namespace afferent {

class OverdueScans {
  public:
    // For elements 0 to elements - 1. A scan is overdue that is this far behind the clock.
    OverdueScans(std::uint32_t elements, Duration limit)
        : limit_(limit), forces_n_(elements), held_(elements) {}

    bool overdue(Duration behind) const noexcept { return behind > limit_; }

    // Keeps the scan in place of earlier samples of its elements. Scans come in the order of time.
    void hold(const Scan& scan);
    bool empty() const noexcept { return count_ == 0; }
    // When the last one held was taken.
    TimePoint time() const noexcept { return time_; }

    // Gives what is held, as scans of neighbouring elements taken at `time`, and holds nothing more. An
    // element is given once, because encoders take slopes from one time to the next.
    template <class Give>
    void release(TimePoint time, const Give& give) {
        for (std::uint32_t begin = 0; count_ > 0; ++begin) {
            if (!held_[begin]) continue;
            std::uint32_t end = begin;
            for (; end < held_.size() && held_[end]; ++end) held_[end] = false;
            count_ -= end - begin;
            give(Scan{time, begin, std::span(forces_n_).subspan(begin, end - begin)});
            begin = end - 1;
        }
    }

    // How many samples newer ones have replaced: they never reach a neuron.
    std::uint64_t skipped_samples() const noexcept { return skipped_; }

  private:
    Duration limit_;
    std::vector<double> forces_n_;
    std::vector<bool> held_;
    std::uint32_t count_ = 0;  // of those held
    TimePoint time_ = TimePoint::min();
    std::uint64_t skipped_ = 0;
};

}  // namespace afferent
