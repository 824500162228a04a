// Converts counts of an analogue-to-digital converter to newtons. Included by whoever builds a scene with
// calibrated sensors.
#pragma once

#include <utility>
#include <vector>

namespace afferent {

// Interpolates linearly between the points; constant before the first and after the last.
class Calibration {
  public:
    struct Point {
        double counts;
        double force_n;
        bool operator==(const Point&) const = default;
    };

    // Throws ParameterError unless there are at least two points, all finite, with strictly increasing
    // counts.
    explicit Calibration(std::vector<Point> points);

    double force_n(double counts) const noexcept;

  private:
    std::vector<Point> points_;
};

}  // namespace afferent
