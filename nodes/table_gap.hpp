// The stretch between two rows of a table, and the samples that are taken of it.
#pragma once

#include <algorithm>
#include <cstdint>

#include "afferent/runtime/time.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

struct TableGap {
    TimePoint row;
    TimePoint next;

    // The number of equal steps, of at most `interval` each, in which samples are taken from one row to the
    // next; 1: the rows are the samples. As clocks jitter, a gap may be longer than its steps by a tenth of
    // an interval.
    std::int64_t steps(Duration interval, scene::Between between) const noexcept {
        if (between == scene::Between::hold) return 1;
        return std::max<std::int64_t>(1, (next - row - interval / 10 + interval - 1ns) / interval);
    }
    // When the k-th step of so many ends.
    TimePoint step(std::int64_t k, std::int64_t steps) const noexcept {
        if (k == steps) return next;
        const double part = static_cast<double>(k) / static_cast<double>(steps);
        return row + Duration(static_cast<std::int64_t>(part * static_cast<double>((next - row).count())));
    }
    double fraction(TimePoint time) const noexcept { return seconds(time - row) / seconds(next - row); }
};

}  // namespace afferent
