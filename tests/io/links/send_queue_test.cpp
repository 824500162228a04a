#include "afferent/io/links/send_queue.hpp"

#include <gtest/gtest.h>

namespace afferent {
namespace {

using Pushed = SendQueue::Pushed;

std::vector<std::byte> frame(int mark, std::size_t size) { return {size, static_cast<std::byte>(mark)}; }

std::vector<int> marks(SendQueue& queue) {
    std::vector<int> found;
    while (!queue.empty()) {
        std::vector<std::byte> out;
        queue.take(out, 0);
        found.push_back(std::to_integer<int>(out.front()));
    }
    return found;
}

TEST(SendQueue, DropsTheOldestPacketsForNewerOnes) {
    SendQueue queue(100);
    EXPECT_EQ(queue.push(frame(1, 40), true), Pushed::whole);
    EXPECT_EQ(queue.push(frame(2, 40), true), Pushed::whole);
    EXPECT_EQ(queue.push(frame(3, 50), true), Pushed::dropped);
    EXPECT_EQ(queue.push(frame(4, 90), true), Pushed::dropped);
    EXPECT_EQ(queue.dropped(), 3U);
    EXPECT_EQ(marks(queue), (std::vector<int>{4}));
}

TEST(SendQueue, NeverDropsWhatIsNoPacket) {
    SendQueue queue(100);
    queue.push(frame(1, 60), false);
    queue.push(frame(2, 30), true);
    EXPECT_EQ(queue.push(frame(3, 60), false), Pushed::dropped);
    EXPECT_EQ(queue.push(frame(4, 60), false), Pushed::whole);
    EXPECT_EQ(marks(queue), (std::vector<int>{1, 3, 4}));
}

TEST(SendQueue, OverflowsAtFourTimesItsLimit) {
    SendQueue queue(100);
    for (int i = 0; i < 4; ++i) EXPECT_EQ(queue.push(frame(i, 100), false), Pushed::whole);
    EXPECT_EQ(queue.push(frame(4, 1), false), Pushed::overflow);
    EXPECT_EQ(queue.bytes(), 400U);
}

TEST(SendQueue, KeepsEverythingWhereNothingMayBeLost) {
    SendQueue queue(100, true);
    for (int i = 0; i < 20; ++i) EXPECT_EQ(queue.push(frame(i, 90), i % 2 == 0), Pushed::whole);
    EXPECT_EQ(queue.bytes(), 1800U);
    EXPECT_EQ(queue.dropped(), 0U);
    EXPECT_EQ(marks(queue).size(), 20U);
}

TEST(SendQueue, TakesAnyFrameWhenEmptyAndGivesWholeOnes) {
    SendQueue queue(100);
    EXPECT_EQ(queue.push(frame(1, 1000), true), Pushed::whole);
    EXPECT_EQ(queue.push(frame(2, 30), false), Pushed::dropped);
    queue.push(frame(3, 30), false);
    queue.push(frame(4, 30), false);
    std::vector<std::byte> out;
    queue.take(out, 65);
    EXPECT_EQ(out.size(), 60U);
    EXPECT_EQ(queue.bytes(), 30U);
}

}  // namespace
}  // namespace afferent
