#include "afferent/nodes/ranks/stopwatch.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace afferent::ranks {
namespace {

// Uses the processor for that long.
void work(double for_s) {
    const double begin = processor_s();
    while (processor_s() < begin + for_s) {
    }
}

TEST(Stopwatch, AddsUpWhatARankDoes) {
    Report report;
    Stopwatch watch(report);
    for (int i = 0; i < 2; ++i) {
        watch.computes();
        work(0.004);
        watch.waits();
        std::this_thread::sleep_for(std::chrono::milliseconds(3));
        watch.does_the_rest();
        work(0.002);
    }
    watch.stop();
    // Sums of differences, which are rounded.
    EXPECT_GE(report.compute_s, 0.008 - 1e-9);
    EXPECT_GE(report.wait_s, 0.006 - 1e-9);
    EXPECT_GE(report.rest_s, 0.004 - 1e-9);
    EXPECT_GE(report.run_s, report.wait_s + 0.012 - 1e-9) << "it works no faster than time passes";
    EXPECT_LE(report.compute_s + report.rest_s, processor_s() + 1e-9) << "all that this program has used";
    EXPECT_LT(report.run_s, 60);
}

}  // namespace
}  // namespace afferent::ranks
