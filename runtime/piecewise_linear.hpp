// A function through points, linear between them.
#pragma once

#include <algorithm>
#include <vector>

namespace afferent {

// One coordinate of the points over another, `from`, which increases strictly; held before the first point
// and beyond the last. At least one point.
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
