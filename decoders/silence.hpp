// What a silence still allows: an afferent that fires seldom is silent most of the time.
#pragma once

#include <algorithm>

#include "afferent/runtime/time.hpp"

namespace afferent {

// No spike; differences to it do not overflow.
constexpr TimePoint never_fired = scene_start - std::chrono::hours(24 * 365 * 100);

// An afferent that has been silent for so long is at rest: no afferent that a hand can be closed by fires
// less often than once in that time.
constexpr Duration at_rest_after = 1s;

// The rate that an afferent may still have, which fired last at `last` and of which nothing is known before
// `known_from` or after `until`: 1/(the known silence since). 0 where this adds nothing to a count over the
// last `memory`, which still holds the spike, and once the afferent is at rest.
constexpr double allowed_hz(TimePoint last, TimePoint known_from, TimePoint until, Duration memory) noexcept {
    constexpr Duration least = 1us;
    const Duration age = until - last;
    if (age < memory || age >= at_rest_after) return 0;
    return 1 / seconds(std::max(until - std::max(last, known_from), least));
}

}  // namespace afferent
