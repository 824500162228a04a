// How the rate of spikes rises with the grip force, and back.
#pragma once

#include <vector>

namespace afferent {

// Linear between its points; constant before the first and after the last.
class ForceRateCurve {
  public:
    struct Point {
        double force_n;
        double rate_hz;
    };

    // Throws ParameterError: at least two points; forces and rates finite, >= 0 and strictly increasing.
    explicit ForceRateCurve(std::vector<Point> points);

    double rate_hz(double force_n) const noexcept;

    // The force at which the rate is reached. 0 at or below the rate of the first point: silence means no
    // force, not the force at which firing begins. Above the curve, the force of the last point.
    double force_n(double rate_hz) const noexcept;

    double largest_n() const noexcept { return points_.back().force_n; }
    const std::vector<Point>& points() const noexcept { return points_; }

  private:
    std::vector<Point> points_;
};

}  // namespace afferent
