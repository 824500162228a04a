#include "afferent/apps/event_loop.hpp"

#include <gtest/gtest.h>

namespace afferent {
namespace {

// Nothing is connected, as between two attempts of a coprocessor.
TEST(EventLoop, WaitsWhereThereIsNothingButTime) {
    EventLoop loop;
    const auto begin = std::chrono::steady_clock::now();
    int polls = 0;
    loop.run([&]() -> std::optional<EventLoop::Time> {
        ++polls;
        const auto now = std::chrono::steady_clock::now();
        if (now - begin > std::chrono::milliseconds(100)) return std::nullopt;
        return now + std::chrono::milliseconds(5);
    });
    EXPECT_GT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(100));
    EXPECT_LT(polls, 100) << "20 at 5 ms each, if nothing else runs";
}

}  // namespace
}  // namespace afferent
