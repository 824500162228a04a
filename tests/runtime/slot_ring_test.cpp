#include "afferent/runtime/slot_ring.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "afferent/runtime/latest.hpp"

namespace afferent {
namespace {

TEST(SlotRing, GivesWhatWasPutInInItsOrder) {
    SlotRing<int> ring(3);
    EXPECT_EQ(ring.next(), nullptr);
    for (int i = 0; i < 10; ++i) {
        *ring.free_slot() = i;
        ring.push();
        ASSERT_NE(ring.next(), nullptr);
        EXPECT_EQ(*ring.next(), i);
        ring.pop();
    }
}

TEST(SlotRing, HasNoRoomOnceItIsFull) {
    SlotRing<int> ring(2);
    for (int i = 0; i < 2; ++i) {
        EXPECT_NE(ring.free_slot(), nullptr);
        ring.push();
    }
    EXPECT_EQ(ring.room(), 0U);
    EXPECT_EQ(ring.free_slot(), nullptr);
    ring.pop();
    EXPECT_NE(ring.free_slot(), nullptr);
}

TEST(SlotRing, KeepsWhatASlotHasAllocated) {
    SlotRing<std::vector<int>> ring(1);
    ring.free_slot()->assign(100, 7);
    const int* const memory = ring.free_slot()->data();
    ring.push();
    ring.pop();
    ring.free_slot()->assign(50, 8);
    EXPECT_EQ(ring.free_slot()->data(), memory);
}

TEST(SlotRing, CarriesEverythingBetweenTwoThreads) {
    constexpr int count = 100'000;
    SlotRing<std::pair<int, int>> ring(16);
    std::thread filler([&] {
        for (int i = 0; i < count;) {
            auto* const slot = ring.free_slot();
            if (!slot) {
                std::this_thread::yield();
                continue;
            }
            *slot = {i, -i};
            ring.push();
            ++i;
        }
    });
    int wrong = 0;
    for (int i = 0; i < count;) {
        const auto* const slot = ring.next();
        if (!slot) {
            std::this_thread::yield();
            continue;
        }
        if (*slot != std::pair(i, -i)) ++wrong;
        ring.pop();
        ++i;
    }
    filler.join();
    EXPECT_EQ(wrong, 0);
}

TEST(Latest, IsWhatWasToldLast) {
    Latest<int> latest;
    EXPECT_EQ(latest.read(), 0);
    latest.tell(1);
    latest.tell(2);
    EXPECT_EQ(latest.read(), 2);
    EXPECT_EQ(latest.read(), 2) << "and stays so";
    latest.tell(3);
    EXPECT_EQ(latest.read(), 3);
}

TEST(Latest, IsNeverTornAndNeverOlderThanWhatWasReadBefore) {
    struct Pair {
        int a = 0;
        int b = 0;
    };
    constexpr int count = 100'000;
    Latest<Pair> latest;
    std::thread teller([&] {
        for (int i = 1; i <= count; ++i) latest.tell({i, -i});
    });
    int wrong = 0;
    for (int last = 0; last < count;) {
        const Pair& read = latest.read();
        if (read.a != -read.b || read.a < last) ++wrong;
        last = read.a;
    }
    teller.join();
    EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace afferent
