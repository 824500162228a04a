// A scene's address-event bus between its neurons and its link.
#include <gtest/gtest.h>

#include <algorithm>

#include "afferent/scene/plan.hpp"
#include "tests/nodes/whole_run.hpp"

namespace afferent {
namespace {

struct BusOutcome {
    std::vector<Event> events;  // as recorded
    std::vector<double> forces_n;
    std::uint64_t fired = 0;
    std::uint64_t received = 0;
    EventBusCounts bus;
    Duration median{};
    Duration longest{};
};

BusOutcome run_over(const std::string& link, const std::string& more = "") {
    const Plan plan = make_plan(Scene::from_text(
        "duration_s: 3 patch { name: 'skin' elements: 60 sensor { full_scale_n: 1 } } link { " + link +
        " } hand { user { close_at_s: 0.2 effort: 0.9 } object { distance_mm: 5 } } " + more));
    BusOutcome outcome;
    const auto run = whole_run(
        plan,
        {.events =
             [&](std::span<const Event> events) {
                 outcome.events.insert(outcome.events.end(), events.begin(), events.end());
             },
         .step = [&](const ControllerStep& step) { outcome.forces_n.push_back(step.estimate.force_n); }});
    outcome.fired = run->coprocessor().events();
    outcome.received = run->received().events;
    if (const EventBus* bus = run->coprocessor().bus()) {
        outcome.bus = bus->counts();
        outcome.median = bus->delay(0.5);
        outcome.longest = bus->delay(1);
    }
    return outcome;
}

TEST(SceneBus, DelaysWhatPassesIt) {
    const BusOutcome without = run_over("tcp {}");
    const BusOutcome with = run_over("tcp {} bus { cycle_ns: 10 rows: 6 row_events: 64 }");
    EXPECT_GT(with.fired, 1000U);
    EXPECT_EQ(with.bus.events, with.fired);
    EXPECT_EQ(with.bus.dropped, 0U);
    EXPECT_EQ(with.events.size(), with.bus.events);
    EXPECT_TRUE(std::is_sorted(with.events.begin(), with.events.end()));
    EXPECT_GE(with.median, 10ns);
    EXPECT_LE(with.longest, 10ns * 6 * 64);
    // Too short to be seen by the decoder.
    EXPECT_EQ(with.forces_n.size(), 3000U);
    EXPECT_EQ(with.forces_n, without.forces_n);
    EXPECT_EQ(with.fired, without.fired);
}

TEST(SceneBus, AccountsForWhatItDrops) {
    for (const char* transport : {"tcp {}", "in_process {}"}) {
        const BusOutcome slow =
            run_over(std::string(transport) + " bus { cycle_ns: 400000 rows: 3 row_events: 4 }");
        EXPECT_GT(slow.bus.dropped, 100U);
        EXPECT_GT(slow.bus.collisions, slow.bus.dropped);
        EXPECT_EQ(slow.events.size(), slow.bus.events);
        // Those that have neither passed nor been dropped wait at the end.
        EXPECT_LE(slow.bus.events + slow.bus.dropped, slow.fired);
        EXPECT_GE(slow.bus.events + slow.bus.dropped + 13, slow.fired);
        EXPECT_TRUE(std::string(transport) == "in_process {}" || slow.received == slow.bus.events);
        EXPECT_LE(slow.longest, 400us * 14);
    }
}

TEST(SceneBus, AccountsForItsEventsBehindALossyChannelToo) {
    const Plan plan = make_plan(
        Scene::from_text("duration_s: 2 link { tcp {} bus { cycle_ns: 900000 } channel { loss: 0.3 } } "
                         "hand { user { close_at_s: 0.2 } object { distance_mm: 5 } }"));
    const auto run = whole_run(plan);
    EXPECT_GT(run->received().events, 50U);
    EXPECT_GT(run->received().lost_events, 10U);
    ASSERT_NE(run->coprocessor().bus(), nullptr);
    EXPECT_EQ(run->received().events + run->received().lost_events,
              run->coprocessor().bus()->counts().events);
}

TEST(SceneBus, IsTheSameForAnyThreads) {
    const std::string bus = "tcp {} bus { cycle_ns: 100000 rows: 5 row_events: 4 }";
    const BusOutcome one = run_over(bus, "runtime { threads: 1 }");
    const BusOutcome four = run_over(bus, "runtime { threads: 4 }");
    EXPECT_GT(one.events.size(), 1000U);
    EXPECT_GT(one.bus.collisions, 100U);
    EXPECT_EQ(one.events, four.events);
    EXPECT_EQ(one.forces_n, four.forces_n);
    EXPECT_EQ(one.bus.collisions, four.bus.collisions);
}

TEST(SceneBus, IsInThePlan) {
    const auto part = [](const std::string& link) {
        const Plan plan = make_plan(Scene::from_text("link { " + link + " }"));
        return found_or_throw(plan.items, "address-event bus", &PlanItem::name);
    };
    EXPECT_FALSE(part("tcp {}").built);
    EXPECT_TRUE(part("tcp {} bus { rows: 3 }").built);
    EXPECT_EQ(part("tcp {} bus { rows: 3 }").reason,
              "link.bus: at most 10000000 events per second, of 3 rows");
}

TEST(SceneBus, IsRefusedWithFieldAndLine) {
    const auto refusal = [](const std::string& bus) {
        try {
            (void)Scene::from_text("\nlink { tcp {}\n bus { " + bus + " } }", "s.txtpb");
        } catch (const SceneError& error) {
            return std::string(error.what());
        }
        return std::string("accepted");
    };
    EXPECT_EQ(refusal("cycle_ns: 0"), "s.txtpb:3:8: link.bus.cycle_ns must be 1 to 1e9, is 0");
    EXPECT_EQ(refusal("rows: 10"),
              "s.txtpb:3:8: link.bus.rows must be from 1 to the number of addresses, is 10");
    EXPECT_EQ(refusal("row_events: 0"), "s.txtpb:3:8: link.bus.row_events must be 1 to 1e7, is 0");
    EXPECT_EQ(refusal("rows: 9 row_events: 2000000"),
              "s.txtpb:3:16: link.bus.row_events must be at most 1e7 on all rows, is 2e+06");
    EXPECT_EQ(refusal("rows: 9"), "accepted");
}

}  // namespace
}  // namespace afferent
