// Linear interpolation between points.
#pragma once

#include <algorithm>
#include <vector>

namespace afferent {

// The coordinate `to` as a function of `from`, which increases strictly over the points: linear between them,
// constant before the first and after the last. There is at least one point.
//
//     interpolate(points, &Point::force_n, &Point::rate_hz, 3.0)
template <class Point>
double interpolate(const std::vector<Point>& points, double Point::*from, double Point::*to,
                   double x) noexcept {
    const auto above =
        std::upper_bound(points.begin(), points.end(), x,
                         [from](double value, const Point& point) { return value < point.*from; });
    if (above == points.begin()) return points.front().*to;
    if (above == points.end()) return points.back().*to;
    const Point& low = *(above - 1);
    return low.*to + ((*above).*to - low.*to) * (x - low.*from) / ((*above).*from - low.*from);
}

}  // namespace afferent
