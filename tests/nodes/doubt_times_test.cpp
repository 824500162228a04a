#include "afferent/nodes/doubt_times.hpp"

#include <gtest/gtest.h>

#include "tests/since_start.hpp"

namespace afferent {
namespace {

TEST(DoubtTimes, CountADoubtUntilTheNextStep) {
    DoubtTimes times;
    EXPECT_TRUE(times.seconds().empty());
    times.add(Doubt::unknown, at(0ms));
    times.add(Doubt::none, at(5ms));
    times.add(Doubt::slow, at(10ms));
    times.add(Doubt::slow, at(15ms));
    times.add(Doubt::none, at(30ms));
    times.add(Doubt::saturated, at(40ms));
    const std::map<std::string, double> expected{{"slow", 0.020}, {"unknown", 0.005}};
    EXPECT_EQ(times.seconds(), expected);
}

}  // namespace
}  // namespace afferent
