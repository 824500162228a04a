// How often neurons fire at a force, and back.
#pragma once

#include <vector>

namespace afferent {

// A rate that rises with force, linear between points, held before the first and beyond the last.
class ForceRateCurve {
  public:
    struct Point {
        double force_n;
        double rate_hz;
    };

    // Throws ParameterError: at least two points; forces and rates finite, >= 0 and strictly increasing.
    explicit ForceRateCurve(std::vector<Point> points);

    double rate_hz(double force_n) const noexcept;

    // The force at which the rate is reached: 0 for no more than the first point's rate, because silence is
    // no force; the last point's force for a rate above the curve.
    double force_n(double rate_hz) const noexcept;

    const std::vector<Point>& points() const noexcept { return points_; }

  private:
    std::vector<Point> points_;
};

}  // namespace afferent
