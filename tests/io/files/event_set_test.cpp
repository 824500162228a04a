#include "afferent/io/files/event_set.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/since_start.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

const EventSet some{
    .events = {{at(1ms), 0}, {at(1ms), 2}, {at(5ms), 1}},
    .population = {.patches = {{"a", 1, "SA1"}, {"b", 2}},
                   .afferents = {{.place = Position{1.5, -2}, .element = 7, .elements = 3}, {}, {}}},
    .resolution = 100us};

TEST(EventSet, IsTheSameAfterItsBytes) {
    EXPECT_EQ(value_or_throw(event_set(to_bytes(some))), some);
    EXPECT_EQ(value_or_throw(event_set(to_bytes({}))), EventSet());
}

// Its bytes may come from a program that a hostile file has taken over.
TEST(EventSet, IsRefusedWhereItsBytesAreWrong) {
    const std::vector<std::byte> whole = to_bytes(some);
    for (std::size_t size = 0; size < whole.size(); ++size) {
        const auto cut = event_set(std::span(whole).first(size));
        EXPECT_TRUE(!cut || cut.value().events.size() < some.events.size()) << size;
    }
    std::vector<std::byte> changed = whole;
    for (std::size_t i = 0; i < whole.size(); ++i) {
        for (int bit = 0; bit < 8; ++bit) {
            changed[i] = whole[i] ^ static_cast<std::byte>(1 << bit);
            const auto read = event_set(changed);
            EXPECT_TRUE(!read || check(read.value())) << i;
        }
        changed[i] = whole[i];
    }
}

TEST(EventSet, IsCheckedForWhatCannotBe) {
    const auto refusal = [](EventSet set) {
        const Result<void> checked = check(set);
        return checked ? "accepted" : checked.error().text;
    };
    EXPECT_EQ(refusal(some), "accepted");
    EventSet wrong = some;
    wrong.population.afferents.pop_back();
    EXPECT_EQ(refusal(wrong), "the patches have 3 afferents, and 2 are told of");
    wrong.population.afferents.clear();
    wrong.population.patches.pop_back();
    EXPECT_EQ(refusal(wrong), "an event has address 2, and the patches have 1 afferents");
    wrong.population.patches.clear();
    EXPECT_EQ(refusal(wrong), "accepted") << "nobody has said which afferents there are";
    std::swap(wrong.events[0], wrong.events[1]);
    EXPECT_EQ(refusal(wrong), "the events are not sorted by time and address");
    EXPECT_EQ(refusal({.events = {{at(-1ns), 0}}}), "an event lies before the start");
    EXPECT_EQ(refusal({.events = {}, .population = {}, .resolution = 0ns}),
              "the resolution of the times is less than 1 ns");
    wrong = some;
    wrong.population.afferents[0].place->y_mm = std::nan("");
    EXPECT_EQ(refusal(wrong), "an afferent has a place that is none");
}

}  // namespace
}  // namespace afferent
