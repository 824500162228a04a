#include "afferent/io/wire/event_bus.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "afferent/runtime/parameter_error.hpp"
#include "tests/counts_nothing.hpp"
#include "tests/since_start.hpp"

namespace afferent {
namespace {

std::vector<Event> passed(EventBus& bus, const std::vector<Event>& events) {
    std::vector<Event> out;
    bus.pass(events, at(1000s), out);
    return out;
}

TEST(EventBus, CountsFromNothing) { EXPECT_TRUE(counts_nothing<EventBusCounts>()); }

TEST(EventBus, DelaysALoneEventByOneCycle) {
    EventBus bus({.addresses = 9, .cycle = 1us});
    EXPECT_EQ(passed(bus, {{at(10us), 4}, {at(20us), 5}}),
              (std::vector<Event>{{at(11us), 4}, {at(21us), 5}}));
    EXPECT_EQ(bus.counts().collisions, 0U);
    EXPECT_EQ(bus.delay(0.5), 1us);
    EXPECT_EQ(bus.delay(1), 1us);
}

TEST(EventBus, ServesItsRowsInTurnAndEachInOrder) {
    EventBus bus({.addresses = 9, .cycle = 1us, .rows = 3});
    const auto out = passed(bus, {{at(0us), 0}, {at(0us), 1}, {at(0us), 2}, {at(0us), 4}, {at(0us), 8}});
    EXPECT_EQ(out,
              (std::vector<Event>{{at(1us), 0}, {at(2us), 4}, {at(3us), 8}, {at(4us), 1}, {at(5us), 2}}));
    EXPECT_EQ(bus.counts().collisions, 4U);
    EXPECT_EQ(bus.delay(1), 5us);
    EXPECT_EQ(bus.delay(0.5), 3us);
}

TEST(EventBus, DropsWhatARowCannotHold) {
    EventBus bus({.addresses = 10, .cycle = 1us, .rows = 2, .row_events = 2});
    const auto out = passed(bus, {{at(0us), 0}, {at(0us), 1}, {at(0us), 2}, {at(0us), 9}});
    EXPECT_EQ(out.size(), 3U);
    EXPECT_EQ(bus.counts().dropped, 1U);
}

// A single server with constant service time and Poisson arrivals: mean wait rho / (2 (1 − rho)) cycles
// (Pollaczek and Khinchine), whatever the order of service.
TEST(EventBus, AgreesWithQueueingTheory) {
    std::mt19937_64 random(1);
    for (const double load : {0.2, 0.5, 0.8}) {
        EventBus bus({.addresses = 1000, .cycle = 1us, .rows = 10, .row_events = 1000});
        std::exponential_distribution<double> gap_us(load);
        std::vector<Event> events(400'000);
        double time_us = 0;
        for (Event& event : events) {
            time_us += gap_us(random);
            event = {at(Duration(std::llround(time_us * 1e3))), static_cast<Address>(random() % 1000)};
        }
        const auto out = passed(bus, events);
        ASSERT_EQ(out.size(), events.size());
        EXPECT_TRUE(std::is_sorted(out.begin(), out.end()));
        double wait_us = 0;
        for (std::size_t i = 0; i < events.size(); ++i)
            wait_us += static_cast<double>((out[i].time - events[i].time).count()) / 1e3 - 1;
        // The sum over all events is the same for any order of service; 400,000 correlated waits, 4 % at load
        // 0.8.
        const double theory = load / (2 * (1 - load));
        EXPECT_NEAR(wait_us / 400'000, theory, 0.04 * theory) << load;
    }
}

TEST(EventBus, IsTheSameHoweverTheEventsAreCut) {
    std::mt19937_64 random(2);
    std::vector<Event> events(5000);
    for (Event& event : events)
        event = {at(Duration(random() % 5'000'000)), static_cast<Address>(random() % 100)};
    std::sort(events.begin(), events.end());
    const EventBusParameters parameters{.addresses = 100, .cycle = 900ns, .rows = 7, .row_events = 4};
    EventBus whole(parameters);
    const auto at_once = passed(whole, events);
    EventBus cut(parameters);
    std::vector<Event> piecewise;
    auto first = events.begin();
    for (TimePoint until = at(100us); until <= at(6ms); until += 100us) {
        const auto last =
            std::partition_point(first, events.end(), [&](const Event& e) { return e.time < until; });
        cut.pass({first, last}, until, piecewise);
        EXPECT_TRUE(piecewise.empty() || piecewise.back().time < until);
        first = last;
    }
    EXPECT_EQ(piecewise, at_once);
    EXPECT_GT(whole.counts().dropped, 0U);
    EXPECT_EQ(whole.counts().events + whole.counts().dropped, events.size());
}

TEST(EventBus, NamesTheParameterThatIsWrong) {
    const auto why = [](const EventBusParameters& parameters) {
        try {
            EventBus bus(parameters);
        } catch (const ParameterError& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_EQ(why({.addresses = 0}), "addresses must be > 0, is 0");
    EXPECT_EQ(why({.addresses = 3, .cycle = 0ns}), "cycle_ns must be > 0, is 0");
    EXPECT_EQ(why({.addresses = 3, .rows = 4}), "rows must be from 1 to the number of addresses, is 4");
    EXPECT_EQ(why({.addresses = 3, .row_events = 0}), "row_events must be > 0, is 0");
    EXPECT_EQ(why({.addresses = 3, .rows = 2, .row_events = 5'000'001}),
              "row_events must be at most 1e7 on all rows, is 5000001");
}

}  // namespace
}  // namespace afferent
