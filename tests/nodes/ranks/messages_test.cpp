#include "afferent/nodes/ranks/messages.hpp"

#include <gtest/gtest.h>

namespace afferent::ranks {
namespace {

TEST(RankMessages, CarryTheEventsOfAWindow) {
    // The first and the last that a window may have; a window lasts a second at most.
    const TimePoint from = scene_start + 5s - Duration(1);
    const TimePoint until = from + 1s;
    const std::vector<Event> sent{{from + Duration(1), 0}, {from + 3ms, 4'294'967'295}, {until, 7}};
    Bytes bytes;
    put_events(bytes, from, until, sent);
    EXPECT_EQ(bytes.size(), 16 + 8 * sent.size());

    std::vector<Event> events{{scene_start, 1}};
    EXPECT_EQ(take_events(bytes, events), until);
    ASSERT_EQ(events.size(), 4U);
    EXPECT_EQ(events.front(), (Event{scene_start, 1}));
    EXPECT_TRUE(std::equal(sent.begin(), sent.end(), events.begin() + 1));
}

TEST(RankMessages, CarryTheEventsOfTheFirstWindow) {
    Bytes bytes;
    put_events(bytes, scene_start - Duration(1), scene_start + 5ms, std::vector<Event>{{scene_start, 3}});
    std::vector<Event> events;
    EXPECT_EQ(take_events(bytes, events), scene_start + 5ms);
    EXPECT_EQ(events, (std::vector<Event>{{scene_start, 3}}));
}

TEST(RankMessages, CarryTheScansOfAWindow) {
    const std::vector<double> first{0.1, -2e300};
    const std::vector<double> third{3};
    Bytes bytes;
    put_scan(bytes, {scene_start + 1ms, 5, first});
    put_scan(bytes, {scene_start + 1ms, 9, {}});
    put_scan(bytes, {scene_start + 2ms, 4'000'000'000, third});
    put_end(bytes, scene_start + 3ms);

    std::vector<double> forces_n;
    std::vector<std::tuple<TimePoint, Address, std::vector<double>>> scans;
    const TimePoint until = take_scans(bytes, forces_n, [&](const Scan& scan) {
        scans.emplace_back(scan.time, scan.first,
                           std::vector<double>(scan.forces_n.begin(), scan.forces_n.end()));
    });
    EXPECT_EQ(until, scene_start + 3ms);
    ASSERT_EQ(scans.size(), 3U);
    EXPECT_EQ(scans[0], std::tuple(scene_start + 1ms, 5U, first));
    EXPECT_EQ(scans[1], std::tuple(scene_start + 1ms, 9U, std::vector<double>{}));
    EXPECT_EQ(scans[2], std::tuple(scene_start + 2ms, 4'000'000'000U, third));
}

TEST(RankMessages, CarryAWindowWithoutScans) {
    Bytes bytes;
    put_end(bytes, scene_start + 3ms);
    std::vector<double> forces_n;
    EXPECT_EQ(take_scans(bytes, forces_n, [](const Scan&) { ADD_FAILURE(); }), scene_start + 3ms);
}

TEST(RankMessages, CarryAReport) {
    const Report report{.windows = 3,
                        .events = 5,
                        .bytes = 7,
                        .samples = 8,
                        .clipped = 9,
                        .compute_s = 0.5,
                        .rest_s = 0.125,
                        .wait_s = 0.25,
                        .run_s = 1};
    Bytes bytes;
    put_report(bytes, report);
    EXPECT_EQ(take_report(bytes), report);
}

TEST(RankMessages, ReportNothingBeforeAnythingIsDone) {
    Bytes bytes;
    put_report(bytes, {});
    const Report report = take_report(bytes);
    EXPECT_EQ(report.windows, 0U);
    EXPECT_EQ(report.events, 0U);
    EXPECT_EQ(report.bytes, 0U);
    EXPECT_EQ(report.samples, 0U);
    EXPECT_EQ(report.clipped, 0U);
    for (const double seconds : {report.compute_s, report.rest_s, report.wait_s, report.run_s})
        EXPECT_EQ(seconds, 0);
}

}  // namespace
}  // namespace afferent::ranks
