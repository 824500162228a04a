#include "afferent/runtime/piecewise_linear.hpp"

#include <gtest/gtest.h>

namespace afferent {
namespace {

struct Point {
    double x, y;
};

TEST(Interpolate, IsLinearBetweenItsPointsAndConstantBeyondThem) {
    std::vector<Point> points{{1, 10}, {3, 30}, {4, 20}, {5, 1000}};
    points.pop_back();  // what lies behind the last point is not read
    const auto at = [&](double x) { return interpolate(points, &Point::x, &Point::y, x); };
    EXPECT_EQ(at(-1), 10);
    EXPECT_EQ(at(1), 10);
    EXPECT_EQ(at(1.5), 15);
    EXPECT_EQ(at(3), 30);
    EXPECT_EQ(at(3.5), 25);
    EXPECT_EQ(at(4), 20);
    EXPECT_EQ(at(4.5), 20);
}

}  // namespace
}  // namespace afferent
