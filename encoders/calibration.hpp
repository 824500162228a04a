// Converts the counts of an analogue-to-digital converter to newtons.
#pragma once

#include <utility>
#include <vector>

namespace afferent {

// Linear between the points, constant before the first and after the last.
class Calibration {
  public:
    struct Point {
        double counts;
        double force_n;
        bool operator==(const Point&) const = default;
    };

    // Throws ParameterError: at least two points, counts strictly increasing, all finite.
    explicit Calibration(std::vector<Point> points);

    double force_n(double counts) const noexcept;

  private:
    std::vector<Point> points_;
};

}  // namespace afferent
