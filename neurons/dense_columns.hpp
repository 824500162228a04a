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

// One kind of number, for each neuron of all populations that share the column. Their arrays are contiguous,
// so that a sweep over many populations reads a few long streams and processors fetch ahead. A sweep over
// separate arrays of a few kilobytes would wait at the beginning of each.
class Column {
  public:
    // With room for so many neurons. The arrays of those beyond lie elsewhere.
    explicit Column(std::size_t room) : room_(room) {}

    // padded(count) zeros, which live as long as this object.
    std::span<double> take(std::size_t count) {
        const std::size_t length = padded(count);
        if (left_.size() < length) {
            const std::size_t size = blocks_.empty() ? std::max(length, room_) : length;
            blocks_.push_back(hwy::AllocateAligned<double>(size));
            left_ = {blocks_.back().get(), size};
        }
        const std::span<double> taken = left_.first(length);
        left_ = left_.subspan(length);
        std::ranges::fill(taken, 0.0);
        return taken;
    }

  private:
    std::size_t room_;
    std::span<double> left_;
    std::vector<hwy::AlignedFreeUniquePtr<double[]>> blocks_;
};

struct Columns {
    std::size_t room;
    Column gap_mv{room};
    Column scaled_g{room};
    Column v_th_mv{room};
    Column delta_g{room};
    Column drives_mv{room};
};

}  // namespace afferent::dense
