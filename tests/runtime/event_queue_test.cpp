#include "afferent/runtime/event_queue.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "tests/counted_allocations.hpp"
#include "tests/since_start.hpp"

namespace afferent {
namespace {

TEST(EventQueue, GivesOutWhatIsDueFirst) {
    EventQueue queue(4);
    EXPECT_TRUE(queue.empty());
    queue.schedule({at(2ms), Kind::packet_deadline, 0});
    queue.schedule({at(1ms), Kind::scan, 7});
    queue.schedule({at(3ms), Kind::step, 0});
    EXPECT_EQ(queue.next(), (Due{at(1ms), Kind::scan, 7}));
    EXPECT_EQ(queue.pop(), (Due{at(1ms), Kind::scan, 7}));
    EXPECT_EQ(queue.pop(), (Due{at(2ms), Kind::packet_deadline, 0}));
    EXPECT_EQ(queue.pop(), (Due{at(3ms), Kind::step, 0}));
    EXPECT_TRUE(queue.empty());
}

TEST(EventQueue, HasRoomForAsManyAsItWasMadeForAndAsWereReserved) {
    EventQueue queue(3);
    const auto fill = [&](int count) {
        const std::uint64_t before = allocations;
        for (int i = 0; i < count; ++i) queue.schedule({at(1ms), Kind::scan, 0});
        while (!queue.empty()) queue.pop();
        return allocations - before;
    };
    EXPECT_EQ(fill(3), 0U);
    EXPECT_GT(fill(4), 0U);
    queue.reserve(100);
    EXPECT_EQ(fill(100), 0U);
}

TEST(EventQueue, BreaksTiesByKindAndThenByAddress) {
    const std::vector<Due> in_order{{at(1ms), Kind::packet_deadline, 9},
                                    {at(1ms), Kind::arrival, 0},
                                    {at(1ms), Kind::step, 0},
                                    {at(1ms), Kind::scan, 0},
                                    {at(1ms), Kind::scan, 1},
                                    {at(1ms), Kind::scan, 2}};
    std::vector<Due> mixed = in_order;
    std::shuffle(mixed.begin(), mixed.end(), std::mt19937(3));
    EventQueue queue(in_order.size());
    for (const Due& due : mixed) queue.schedule(due);
    for (const Due& due : in_order) EXPECT_EQ(queue.pop(), due);
}

TEST(EventQueue, RemovesAKindAndKeepsTheOrderOfTheRest) {
    EventQueue queue(8);
    for (const int ms : {5, 1, 4, 2, 3})
        queue.schedule({at(std::chrono::milliseconds(ms)), ms % 2 ? Kind::scan : Kind::step, 0});
    queue.remove(Kind::scan);
    EXPECT_EQ(queue.pop().time, at(2ms));
    EXPECT_EQ(queue.pop().time, at(4ms));
    EXPECT_TRUE(queue.empty());
    queue.schedule({at(1ms), Kind::step, 0});
    queue.clear();
    EXPECT_TRUE(queue.empty());
}

TEST(EventQueue, IsASortedSetWhateverTheOrderOfCalls) {
    std::mt19937 random(4);
    EventQueue queue(0);
    std::multiset<Due> expected;
    for (int i = 0; i < 5000; ++i) {
        if (expected.empty() || random() % 2) {
            const Due due{at(Duration(random() % 20)), static_cast<Kind>(random() % 4),
                          static_cast<Address>(random() % 5)};
            queue.schedule(due);
            expected.insert(due);
        } else {
            ASSERT_EQ(queue.pop(), *expected.begin());
            expected.erase(expected.begin());
        }
    }
}

}  // namespace
}  // namespace afferent
