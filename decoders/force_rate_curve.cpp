#include "afferent/decoders/force_rate_curve.hpp"

#include "afferent/runtime/parameter_error.hpp"
#include "afferent/runtime/piecewise_linear.hpp"

namespace afferent {
ForceRateCurve::ForceRateCurve(std::vector<Point> points) : points_(std::move(points)) {
    if (points_.size() < 2)
        throw ParameterError("curve", "at least two points", std::to_string(points_.size()));
    Point before{-1, -1};
    for (const Point& point : points_) {
        require(point.force_n >= 0 && point.force_n > before.force_n, "curve.force_n", ">= 0 and increasing",
                point.force_n);
        require(point.rate_hz >= 0 && point.rate_hz > before.rate_hz, "curve.rate_hz", ">= 0 and increasing",
                point.rate_hz);
        before = point;
    }
}

double ForceRateCurve::rate_hz(double force_n) const noexcept {
    return interpolate(points_, &Point::force_n, &Point::rate_hz, force_n);
}

double ForceRateCurve::force_n(double rate_hz) const noexcept {
    if (!(rate_hz > points_.front().rate_hz)) return 0;
    return interpolate(points_, &Point::rate_hz, &Point::force_n, rate_hz);
}

}  // namespace afferent
