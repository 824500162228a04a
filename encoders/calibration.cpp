#include "afferent/encoders/calibration.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/runtime/parameter_error.hpp"

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
    const auto above = std::upper_bound(points_.begin(), points_.end(), counts,
                                        [](double value, const Point& point) { return value < point.counts; });
    if (above == points_.begin()) return points_.front().force_n;
    if (above == points_.end()) return points_.back().force_n;
    const Point& low = *(above - 1);
    return low.force_n + (above->force_n - low.force_n) * (counts - low.counts) / (above->counts - low.counts);
}

}  // namespace afferent
