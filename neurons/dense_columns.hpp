// The arrays of populations that are swept one after the other.
#pragma once

#include <hwy/aligned_allocator.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "afferent/neurons/dense_kernel.hpp"

namespace afferent::dense {

// How long the array of so many neurons is: whole vectors.
constexpr std::size_t padded(std::size_t count) { return (count + max_lanes - 1) / max_lanes * max_lanes; }

// What is stored of one kind for each neuron. The arrays of all populations lie one behind the other: so a
// sweep over them reads and writes a few long streams, which processors fetch ahead, where arrays of a few
// kilobytes all over the memory would make it wait at the beginning of each.
class Column {
  public:
    // padded(count) zeros, which live as long as this object. The first call makes room for so many; arrays
    // beyond it lie elsewhere.
    std::span<double> take(std::size_t count, std::size_t room) {
        const std::size_t length = padded(count);
        if (left_.size() < length) {
            const std::size_t size = blocks_.empty() ? std::max(length, room) : length;
            blocks_.push_back(hwy::AllocateAligned<double>(size));
            left_ = {blocks_.back().get(), size};
        }
        const std::span<double> taken = left_.first(length);
        left_ = left_.subspan(length);
        std::ranges::fill(taken, 0.0);
        return taken;
    }

  private:
    std::span<double> left_;
    std::vector<hwy::AlignedFreeUniquePtr<double[]>> blocks_;
};

struct Columns {
    std::size_t room;  // of each
    Column gap_mv = {};
    Column scaled_g = {};
    Column v_th_mv = {};
    Column delta_g = {};
    Column drives_mv = {};
};

}  // namespace afferent::dense
