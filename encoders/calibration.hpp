// From a converter's counts to newtons.
#pragma once

#include <utility>
#include <vector>

namespace afferent {

// Linear between the points, held beyond the first and the last.
class Calibration {
  public:
    struct Point {
        double counts;
        double force_n;
    };

    // Throws ParameterError: at least two points, counts strictly increasing, all finite.
    explicit Calibration(std::vector<Point> points);

    double force_n(double counts) const noexcept;

  private:
    std::vector<Point> points_;
};

}  // namespace afferent
