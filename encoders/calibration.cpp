#include "afferent/encoders/calibration.hpp"

#include <cmath>

#include "afferent/runtime/parameter_error.hpp"
#include "afferent/runtime/piecewise_linear.hpp"

namespace afferent {

Calibration::Calibration(std::vector<Point> points) : points_(std::move(points)) {
    if (points_.size() < 2)
        throw ParameterError("calibration", "at least two points", std::to_string(points_.size()));
    double before = -HUGE_VAL;
    for (const Point& point : points_) {
        require(point.counts > before, "calibration.counts", "increasing", point.counts);
        require(true, "calibration.force_n", "finite", point.force_n);
        before = point.counts;
    }
}

double Calibration::force_n(double counts) const noexcept {
    return interpolate(points_, &Point::counts, &Point::force_n, counts);
}

}  // namespace afferent
