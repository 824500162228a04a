#include "afferent/view/feed.hpp"

#include <gtest/gtest.h>

#include <set>
#include <thread>

#include "tests/counted_allocations.hpp"

namespace afferent {
namespace {

const RasterLayout nine(std::vector<RasterLayout::Afferents>{{"a", 9}});

ControllerStep step_at(TimePoint time, double force_n) {
    ControllerStep step{};
    step.time = time;
    step.true_force_n = force_n + 1;
    step.estimate = {.force_n = force_n, .sigma_n = 0.5, .rate_hz = 10, .doubt = Doubt::slow};
    step.gain = 0.25;
    step.effort.closing = 0.75;
    step.command = 0.125;
    return step;
}

std::uint64_t events_in(const Portion& portion) {
    std::uint64_t sum = 0;
    for (const RasterRun& run : portion.raster)
        for (const std::uint32_t count : run.counts) sum += count;
    return sum;
}

TEST(ViewFeed, PassesOnTheLastStepOfEachInterval) {
    ViewFeed feed(nine);
    for (int i = 0; i < 100; ++i) feed.step(step_at(scene_start + i * 1ms, i));
    feed.steps_end();
    const Portion portion = feed.take();
    ASSERT_EQ(portion.samples.size(), 5U);
    for (std::size_t i = 0; i < 5; ++i) {
        const ViewSample& sample = portion.samples[i];
        EXPECT_EQ(sample.time, scene_start + i * 20ms + 19ms);
        EXPECT_EQ(sample.estimate_n, static_cast<double>(i) * 20 + 19);
        EXPECT_EQ(sample.true_n, sample.estimate_n + 1);
        EXPECT_EQ(sample.gain, 0.25);
        EXPECT_EQ(sample.doubt, Doubt::slow);
        EXPECT_EQ(sample.emg, 0.75);
        EXPECT_EQ(sample.command, 0.125);
    }
    EXPECT_EQ(feed.dropped(), 0U);
}

TEST(ViewFeed, DropsAndCountsWhatNobodyTakes) {
    ViewFeed feed(nine);
    const std::uint64_t before = allocations;
    for (int i = 0; i < 1'000'000; ++i) {
        const TimePoint now = scene_start + i * 1ms;
        feed.step(step_at(now, 1));
        const Event event{now, 3};
        feed.events({&event, 1});
        feed.silent_until(now);
        feed.link(MonotonicTime(now.time_since_epoch()), [&] { return LinkState{.time = now}; });
        if (i % 1000 == 0) feed.note(now, "a short text");
    }
    EXPECT_EQ(allocations, before) << "memory grows";
    // 1,000 s: samples of 20 ms, spans of 40 ms, states of 100 ms, a note each second; about ten seconds are
    // kept.
    const std::uint64_t told = 50'000 + 25'000 + 10'000 + 1'000;
    EXPECT_GT(feed.dropped(), told - 1100);
    EXPECT_LT(feed.dropped(), told);
    const Portion portion = feed.take();
    ASSERT_GT(portion.samples.size(), 500U);
    EXPECT_EQ(portion.samples.front().time, scene_start + 19ms);
    // What comes next is passed on again.
    feed.step(step_at(scene_start + 1'000'000ms, 2));
    feed.steps_end();
    EXPECT_FALSE(feed.take().empty());
}

TEST(ViewFeed, TellsSilenceFromWhatIsNotKnown) {
    ViewFeed feed(nine);
    const auto bins_of = [](const Portion& portion) {
        std::set<std::int64_t> bins;
        for (const RasterRun& run : portion.raster)
            for (std::size_t i = 0; i < run.counts.size() / nine.rows(); ++i)
                bins.insert(run.first_bin + static_cast<std::int64_t>(i));
        return bins;
    };
    Event event{scene_start + 1s, 3};
    feed.events({&event, 1});
    for (int ms = 1000; ms <= 2000; ms += 10) feed.silent_until(scene_start + ms * 1ms);
    feed.events_unknown();
    for (int ms = 2000; ms <= 2500; ms += 10) feed.events_unknown();
    event.time = scene_start + 2600ms;
    feed.gap(scene_start + 2480ms, scene_start + 2590ms);
    feed.events({&event, 1});
    feed.events_end();
    const Portion portion = feed.take();
    EXPECT_EQ(events_in(portion), 2U);
    const auto bins = bins_of(portion);
    // An event may be told 250 ms late, and bins are of 1 ms.
    constexpr std::int64_t silence = 1750;
    for (std::int64_t bin = 1000; bin < silence; ++bin) EXPECT_TRUE(bins.contains(bin)) << bin;
    for (std::int64_t bin = silence + 40; bin < 2560; ++bin) EXPECT_FALSE(bins.contains(bin)) << bin;
    ASSERT_EQ(portion.gaps.size(), 1U);
    EXPECT_EQ(portion.gaps[0].begin, scene_start + 2480ms);
    EXPECT_EQ(portion.gaps[0].end, scene_start + 2590ms);

    // As a session tells that begins in the middle of the scene.
    feed.gap(scene_start, scene_start + 3s);
    feed.gap(scene_start, scene_start + 2s);
    const auto gaps = feed.take().gaps;
    ASSERT_EQ(gaps.size(), 1U);
    EXPECT_EQ(gaps[0].begin, event.time);
    EXPECT_EQ(gaps[0].end, scene_start + 3s);
}

TEST(ViewFeed, BeginsANewCourseWithoutMixingItWithTheLast) {
    ViewFeed feed(nine);
    const auto tell = [&](Address address, double force_n) {
        for (int i = 0; i < 100; ++i) {
            feed.step(step_at(scene_start + i * 1ms, force_n));
            const Event event{scene_start + i * 1ms, address};
            feed.events({&event, 1});
        }
    };
    tell(1, 5);
    feed.events_start_over();
    feed.steps_start_over();
    tell(2, 6);
    feed.steps_end();
    feed.events_end();
    std::uint32_t course = 0;
    std::uint64_t events_of_the_last = 0;
    std::size_t samples_of_the_last = 0;
    for (int i = 0; i < 10; ++i) {
        const Portion portion = feed.take();
        EXPECT_GE(feed.course(), course);
        course = feed.course();
        for (const ViewSample& sample : portion.samples) EXPECT_EQ(sample.estimate_n, course == 0 ? 5 : 6);
        if (course == 0) continue;
        events_of_the_last += events_in(portion);
        samples_of_the_last += portion.samples.size();
    }
    EXPECT_EQ(course, 1U);
    EXPECT_EQ(events_of_the_last, 100U);
    EXPECT_EQ(samples_of_the_last, 5U) << "one each 20 ms";
}

TEST(ViewFeed, IsFilledByThreeThreadsAndTakenByAFourth) {
    ViewFeed feed(nine);
    constexpr int steps = 20'000;
    std::atomic<int> running{2};
    std::thread stepping([&] {
        for (int i = 0; i < steps; ++i) feed.step(step_at(scene_start + i * 1ms, i));
        feed.steps_end();
        --running;
    });
    std::thread telling([&] {
        for (int i = 0; i < steps; ++i) {
            const Event event{scene_start + i * 1ms, 4};
            feed.events({&event, 1});
            feed.link(MonotonicTime(i * 1ms), [&] { return LinkState{.time = scene_start + i * 1ms}; });
        }
        feed.events_end();
        --running;
    });
    Portion all;
    while (running > 0) all.append(feed.take());
    stepping.join();
    telling.join();
    all.append(feed.take());
    // Each part came whole or not at all.
    EXPECT_FALSE(all.samples.empty());
    EXPECT_LE(all.samples.size(), steps / 20U);
    EXPECT_EQ(events_in(all) % 40, 0U);
    EXPECT_EQ(all.samples.size() + all.raster.size() + all.link_points.size() + feed.dropped(),
              steps / 20U + steps / 40U + steps / 100U);
    for (const ViewSample& sample : all.samples)
        EXPECT_EQ(sample.time, scene_start + sample.estimate_n * 1ms);
}

}  // namespace
}  // namespace afferent
