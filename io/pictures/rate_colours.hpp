// The colours of a rate on a map: from pale to dark, so that people of any colour vision see the order.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace afferent {

// From straw over orange and red to a dark violet; each is darker than the one before. Red, green, blue.
inline constexpr std::array<std::array<double, 3>, 5> rate_stops{
    {{252, 226, 150}, {247, 170, 63}, {221, 94, 42}, {152, 32, 78}, {56, 8, 74}}};

// The colour of a share of the highest rate, as 65536 red + 256 green + blue.
inline int rate_colour(double share) {
    const double at = std::clamp(share, 0.0, 1.0) * (rate_stops.size() - 1);
    const std::size_t low = std::min(static_cast<std::size_t>(at), rate_stops.size() - 2);
    int colour = 0;
    for (std::size_t part = 0; part < 3; ++part)
        colour = 256 * colour +
                 static_cast<int>(std::lround(std::lerp(rate_stops[low][part], rate_stops[low + 1][part],
                                                        at - static_cast<double>(low))));
    return colour;
}

}  // namespace afferent
