// A coprocessor that falls behind the clock: what its neurons are given, and what it tells. In virtual time.
#include "afferent/nodes/overdue_scans.hpp"

#include <map>

#include "tests/nodes/two_nodes.hpp"
#include "tests/since_start.hpp"

namespace afferent {
namespace {

struct Given {
    TimePoint time;
    Address first;
    std::vector<double> forces_n;
    bool operator==(const Given&) const = default;
};

std::vector<Given> released(OverdueScans& overdue, TimePoint time) {
    std::vector<Given> all;
    overdue.release(time, [&](const Scan& scan) {
        all.push_back({scan.time, scan.first, {scan.forces_n.begin(), scan.forces_n.end()}});
    });
    return all;
}

TEST(OverdueScans, KeepTheNewestSampleOfEachElement) {
    OverdueScans overdue(8, 20ms);
    EXPECT_FALSE(overdue.overdue(20ms));
    EXPECT_TRUE(overdue.overdue(21ms));
    const std::vector<double> early{1, 2, 3};
    const std::vector<double> late{4, 5};
    overdue.hold({at(5ms), 1, early});
    overdue.hold({at(10ms), 2, late});
    overdue.hold({at(10ms), 7, late});  // the scene has no element 8
    EXPECT_FALSE(overdue.empty());
    EXPECT_EQ(overdue.time(), at(10ms));
    EXPECT_EQ(overdue.skipped_samples(), 2U);
    EXPECT_EQ(released(overdue, at(15ms)),
              (std::vector<Given>{{at(15ms), 1, {1, 4, 5}}, {at(15ms), 7, {4}}}));
    EXPECT_TRUE(overdue.empty());
    EXPECT_EQ(released(overdue, at(20ms)), std::vector<Given>{});
}

// A force that rises and is gone while the process is held up, and is felt by both kinds of encoders.
std::string press_that_ends(const std::string& runtime) {
    return "duration_s: 2 patch { name: 'firm' elements: 3 } "
           "patch { name: 'quick' elements_of: 'firm' encoder { transient { gain_mv_s_per_n: 0.5 } } } "
           "link { tcp {} } runtime { " +
           runtime +
           " } source { profile { point { time_s: 0.1 force_n: 0 } point { time_s: 0.3 force_n: 6 } "
           "point { time_s: 0.9 force_n: 6 } point { time_s: 1 force_n: 0 } } }";
}

// Until 0.6 s all is well; then nothing runs until 1.2 s.
void hold_up(TwoNodes& two) {
    two.start();
    two.run_for(600ms);
    two.now += 600ms;
    two.run_to_the_end();
}

std::map<Address, int> events_after(const std::vector<Event>& events, TimePoint time) {
    std::map<Address, int> count;
    for (const Event& event : events)
        if (event.time > time) ++count[event.address];
    return count;
}

TEST(OverdueScans, AreComputedHoweverLateUnlessTheSceneSaysOtherwise) {
    TwoNodes two(press_that_ends(""));
    hold_up(two);
    EXPECT_EQ(two.coprocessor.node->link_end().overdue(), nullptr);
    EXPECT_EQ(two.coprocessor.events, outcome_of_run(two.plan).events);
    ASSERT_TRUE(two.coprocessor.node->pacer());
    EXPECT_GT(two.coprocessor.node->pacer()->missed_deadlines(), 0U);
}

TEST(OverdueScans, LetTheNeuronsCatchUpWithTheNewestForces) {
    TwoNodes two(press_that_ends("skip_scans_after_ms: 20"));
    hold_up(two);
    const std::vector<Event>& events = two.coprocessor.events;
    const std::vector<Event> in_time = outcome_of_run(two.plan).events;
    const auto before = [](const std::vector<Event>& all) {
        std::vector<Event> early;
        for (const Event& event : all)
            if (event.time < scene_start + 600ms) early.push_back(event);
        return early;
    };
    EXPECT_GT(before(in_time).size(), 20U);
    EXPECT_EQ(before(events), before(in_time)) << "nothing is skipped as long as nothing is late";

    // Three elements, sampled every 5 ms, miss the scans from 0.6 s to 20 ms before 1.2 s; whether the first
    // and the last are among them depends on rounding.
    ASSERT_NE(two.coprocessor.node->link_end().overdue(), nullptr);
    const std::uint64_t skipped = two.coprocessor.node->link_end().overdue()->skipped_samples();
    EXPECT_NEAR(static_cast<double>(skipped) / 3, 580.0 / 5, 2);

    // The force has gone meanwhile. It falls at once for sustained neurons, and they are silent from then on;
    // transient ones feel a slope over the time that it really took.
    ASSERT_FALSE(events_after(in_time, scene_start + 1s).contains(0));
    EXPECT_TRUE(events_after(events, scene_start + 1195ms).empty());
    EXPECT_LE(events.size(), 2 * in_time.size());
}

}  // namespace
}  // namespace afferent
