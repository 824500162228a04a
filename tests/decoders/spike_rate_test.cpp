#include "afferent/decoders/spike_rate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/since_start.hpp"

namespace afferent {
namespace {

TEST(SpikeRate, CountsTheEventsOfTheWindowAlone) {
    SpikeRate rate(2, 60ms);
    rate.observe(at(0ms), at(100ms), std::vector<Event>{{at(10ms), 0}, {at(50ms), 1}, {at(80ms), 0}});
    rate.advance(at(100ms));
    EXPECT_EQ(rate.events(), 2U);
    EXPECT_EQ(rate.events_of(0), 1U);
    EXPECT_EQ(rate.events_of(1), 1U);
    EXPECT_EQ(rate.known(), 60ms);
    rate.advance(at(110ms));
    EXPECT_EQ(rate.events(), 1U) << "the window begins just after 50 ms, so that event has left";
}

TEST(SpikeRate, KnowsNothingThatHasNotBeenHeard) {
    SpikeRate rate(1, 60ms);
    rate.observe(at(0ms), at(100ms), {});
    rate.advance(at(120ms));
    EXPECT_EQ(rate.known(), 40ms);
    rate.advance(at(200ms));
    EXPECT_EQ(rate.known(), 0ms);
}

TEST(SpikeRate, CountsPresumedSilenceAsKnownUntilItIsLost) {
    SpikeRate rate(1, 60ms);
    rate.observe(at(0ms), at(100ms), {});
    rate.presume_silence(at(115ms));
    rate.advance(at(120ms));
    EXPECT_EQ(rate.known(), 55ms);
    rate.lose(at(100ms), at(110ms));
    EXPECT_EQ(rate.known(), 45ms);
}

TEST(SpikeRate, KnowsNothingBeforeItsStart) {
    SpikeRate rate(1, 60ms);
    rate.observe(at(0ms), at(10ms), {});
    rate.advance(at(10ms));
    EXPECT_EQ(rate.known(), 10ms);
}

TEST(SpikeRate, CountsAGapAsUnknownAndNotAsSilence) {
    SpikeRate told(1, 60ms);
    told.observe(at(0ms), at(50ms), {});
    told.lose(at(50ms), at(70ms));
    told.observe(at(70ms), at(100ms), {});
    told.advance(at(100ms));
    EXPECT_EQ(told.known(), 40ms);

    SpikeRate seen(1, 60ms);
    seen.observe(at(0ms), at(50ms), {});
    seen.observe(at(70ms), at(100ms), {});
    seen.advance(at(100ms));
    EXPECT_EQ(seen.known(), 40ms) << "the time between two spans is a gap";
}

TEST(SpikeRate, TakesNoRoomForLossesThatFollowEachOther) {
    SpikeRate rate(1, 60s);
    const std::size_t bytes = rate.heap_bytes();
    for (Duration begin = 0ms; begin < 50s; begin += 1ms) rate.lose(at(begin), at(begin + 1ms));
    rate.observe(at(50s), at(51s), {});
    rate.advance(at(51s));
    EXPECT_EQ(rate.known(), 1s);
    EXPECT_EQ(rate.heap_bytes(), bytes);
}

TEST(SpikeRate, ForgetsEverythingWhenReset) {
    SpikeRate rate(1, 60ms);
    rate.observe(at(0ms), at(50ms), std::vector<Event>{{at(40ms), 0}});
    rate.reset(at(55ms));
    rate.advance(at(60ms));
    EXPECT_EQ(rate.events(), 0U);
    EXPECT_EQ(rate.events_of(0), 0U);
    EXPECT_EQ(rate.known(), 0ms);
}

// Against a count of all events so far, over random packets and times, with more events than there is room
// for at first.
TEST(SpikeRate, AgreesWithARecount) {
    std::mt19937 random(1);
    SpikeRate rate(3, 60ms);
    std::vector<Event> all;
    const auto below = [&](unsigned n) { return static_cast<std::uint32_t>(random() % n); };
    for (int packet = 0; packet < 100; ++packet) {
        const TimePoint begin = at(packet * 5ms);
        const TimePoint end = begin + 5ms;
        std::vector<Event> events(below(1000));
        for (Event& event : events) event = {begin + Duration(below(5'000'000)), below(3)};
        std::sort(events.begin(), events.end());
        all.insert(all.end(), events.begin(), events.end());
        rate.observe(begin, end, events);
        const TimePoint now = end + Duration(below(3'000'000));
        rate.advance(now);
        const auto within = std::count_if(all.begin(), all.end(),
                                          [&](const Event& event) { return event.time > now - 60ms; });
        ASSERT_EQ(rate.events(), static_cast<std::size_t>(within));
        ASSERT_EQ(rate.events(), rate.events_of(0) + rate.events_of(1) + rate.events_of(2));
    }
}

}  // namespace
}  // namespace afferent
