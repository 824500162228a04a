#include "afferent/runtime/parallel.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <stdexcept>
#include <thread>
#include <vector>

namespace afferent {
namespace {

TEST(Workers, RunsEveryPieceOnceForAnyNumberOfThreads) {
    for (const std::size_t threads : {1U, 2U, 4U}) {
        Workers workers(threads);
        std::vector<int> runs(1000, 0);
        for (int window = 0; window < 10; ++window)
            workers.run(runs.size(), [&](std::size_t i) { ++runs[i]; });
        EXPECT_EQ(std::accumulate(runs.begin(), runs.end(), 0), 10'000);
    }
}

TEST(Workers, StaysOnTheCallersThreadWhenThereIsOne) {
    Workers workers(1);
    const auto caller = std::this_thread::get_id();
    workers.run(8, [&](std::size_t) { EXPECT_EQ(std::this_thread::get_id(), caller); });
}

TEST(Workers, ThrowsTheExceptionOfAPiece) {
    for (const std::size_t threads : {1U, 2U}) {
        Workers workers(threads);
        EXPECT_THROW(workers.run(4,
                                 [](std::size_t i) {
                                     if (i == 2) throw std::runtime_error("piece 2");
                                 }),
                     std::runtime_error);
    }
}

}  // namespace
}  // namespace afferent
