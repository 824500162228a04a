#include "afferent/io/links/send_queue.hpp"

#include <gtest/gtest.h>

namespace afferent {
namespace {

using Kind = SendQueue::Kind;
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
    EXPECT_EQ(queue.push(frame(1, 40), Kind::packet), Pushed::whole);
    EXPECT_EQ(queue.push(frame(2, 40), Kind::packet), Pushed::whole);
    EXPECT_EQ(queue.push(frame(3, 50), Kind::packet), Pushed::dropped);
    EXPECT_EQ(queue.push(frame(4, 90), Kind::packet), Pushed::dropped);
    EXPECT_EQ(queue.dropped(), 3U);
    EXPECT_EQ(marks(queue), (std::vector<int>{4}));
}

TEST(SendQueue, DropsWithAPacketThoseThatCannotBeReadWithoutIt) {
    SendQueue queue(100);
    queue.push(frame(1, 30), Kind::packet);
    queue.push(frame(2, 10), Kind::message);
    queue.push(frame(3, 20), Kind::follower);
    queue.push(frame(4, 20), Kind::packet);
    queue.push(frame(5, 10), Kind::follower);
    EXPECT_EQ(queue.push(frame(6, 20), Kind::follower), Pushed::dropped);
    EXPECT_EQ(queue.dropped(), 2U);
    EXPECT_EQ(marks(queue), (std::vector<int>{2, 4, 5, 6}));
}

TEST(SendQueue, DropsAPacketThatFollowsWhatWasDropped) {
    SendQueue queue(100);
    queue.push(frame(1, 60), Kind::message);
    queue.push(frame(2, 30), Kind::packet);
    queue.push(frame(3, 10), Kind::follower);
    EXPECT_EQ(queue.push(frame(4, 20), Kind::follower), Pushed::dropped);
    EXPECT_EQ(queue.dropped(), 3U);
    EXPECT_EQ(queue.push(frame(5, 1), Kind::message), Pushed::whole);
    EXPECT_EQ(queue.push(frame(6, 1), Kind::follower), Pushed::dropped) << "nor what follows that";
    EXPECT_EQ(queue.push(frame(7, 1), Kind::packet), Pushed::whole);
    EXPECT_EQ(queue.push(frame(8, 1), Kind::follower), Pushed::whole);
    EXPECT_EQ(queue.dropped(), 4U);
    EXPECT_EQ(marks(queue), (std::vector<int>{1, 5, 7, 8}));
    // One that has been taken is not dropped.
    EXPECT_EQ(queue.push(frame(9, 1), Kind::follower), Pushed::whole);
}

TEST(SendQueue, NeverDropsWhatIsNoPacket) {
    SendQueue queue(100);
    queue.push(frame(1, 60), Kind::message);
    queue.push(frame(2, 30), Kind::packet);
    EXPECT_EQ(queue.push(frame(3, 60), Kind::message), Pushed::dropped);
    EXPECT_EQ(queue.push(frame(4, 60), Kind::message), Pushed::whole);
    EXPECT_EQ(marks(queue), (std::vector<int>{1, 3, 4}));
}

TEST(SendQueue, OverflowsAtFourTimesItsLimit) {
    SendQueue queue(100);
    for (int i = 0; i < 4; ++i) EXPECT_EQ(queue.push(frame(i, 100), Kind::message), Pushed::whole);
    EXPECT_EQ(queue.push(frame(4, 1), Kind::message), Pushed::overflow);
    EXPECT_EQ(queue.bytes(), 400U);
}

TEST(SendQueue, KeepsEverythingWhereNothingMayBeLost) {
    SendQueue queue(100, true);
    for (int i = 0; i < 20; ++i)
        EXPECT_EQ(queue.push(frame(i, 90), i % 2 == 0 ? Kind::packet : Kind::message), Pushed::whole);
    EXPECT_EQ(queue.bytes(), 1800U);
    EXPECT_EQ(queue.dropped(), 0U);
    EXPECT_EQ(marks(queue).size(), 20U);
}

TEST(SendQueue, TakesAnyFrameWhenEmptyAndGivesWholeOnes) {
    SendQueue queue(100);
    EXPECT_EQ(queue.push(frame(1, 1000), Kind::packet), Pushed::whole);
    EXPECT_EQ(queue.push(frame(2, 30), Kind::message), Pushed::dropped);
    queue.push(frame(3, 30), Kind::message);
    queue.push(frame(4, 30), Kind::message);
    std::vector<std::byte> out;
    queue.take(out, 65);
    EXPECT_EQ(out.size(), 60U);
    EXPECT_EQ(queue.bytes(), 30U);
}

}  // namespace
}  // namespace afferent
