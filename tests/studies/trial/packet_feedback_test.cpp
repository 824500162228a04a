// When events reach the hand, and what the hand takes for their time.
#include "afferent/studies/trial/packet_feedback.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <utility>
#include <vector>

#include "tests/since_start.hpp"
#include "tests/studies/trial/example_trial.hpp"

namespace afferent {
namespace {

struct Taken {
    std::optional<TimeSpan> gap;
    TimeSpan known;
    std::vector<Event> events;
};

// Sends the events that it is given, and keeps what it receives.
class Recorder final : public PacketFeedback {
  public:
    Recorder(const Plan& plan, std::vector<Event> events)
        : PacketFeedback(plan, packet_layout(plan)), events_(std::move(events)) {}
    void sense(const Scan&) override {}
    const ControllerStep& step(TimePoint, const Emg&, GripState) override { return step_; }
    const std::vector<Taken>& taken() const { return taken_; }

  protected:
    std::span<const Event> events_before(TimePoint deadline) override {
        const std::size_t first = given_;
        while (given_ < events_.size() && events_[given_].time < deadline) ++given_;
        return std::span(events_).subspan(first, given_ - first);
    }
    void take(const Reception& reception) override {
        taken_.push_back(
            {reception.gap, reception.known, {reception.events.begin(), reception.events.end()}});
    }

  private:
    std::vector<Event> events_;
    std::size_t given_ = 0;
    std::vector<Taken> taken_;
    ControllerStep step_{};
};

// Two events in one packet of 5 ms, and one in each of the next two; the packets come 1 ms after they were
// closed.
std::vector<Taken> carried(bool untimed, bool second_is_lost = false) {
    Scene scene = example_trial();
    scene.link.packet_ms = 5;
    scene.link.delivery_ms = 2;
    scene.trial->untimed_events = untimed;
    const Plan plan = make_plan(scene);
    Recorder feedback(plan, {{at(11ms), 3}, {at(12ms), 1}, {at(16ms), 3}, {at(22ms), 3}});
    feedback.begin(1);
    Channel channel(ChannelParameters{.latency = 1ms});
    for (const TimePoint deadline : {at(5ms), at(10ms), at(15ms), at(20ms), at(25ms)}) {
        feedback.close(deadline, channel);
        while (const auto arrival = channel.next_arrival(deadline + 1ms)) {
            const auto frame = channel.arrive();
            if (second_is_lost && deadline == at(20ms)) continue;
            feedback.arrive(frame, *arrival);
            while (feedback.next_act()) feedback.act();
        }
    }
    return feedback.taken();
}

TEST(PacketFeedback, GivesEventsTheirOwnTimes) {
    const std::vector<Taken> taken = carried(false);
    ASSERT_EQ(taken.size(), 3U);
    EXPECT_EQ(taken[0].known, (TimeSpan{at(0ms), at(15ms)}));
    EXPECT_EQ(taken[0].events, (std::vector<Event>{{at(11ms), 3}, {at(12ms), 1}}));
    EXPECT_EQ(taken[1].known, (TimeSpan{at(15ms), at(20ms)}));
    EXPECT_EQ(taken[1].events, (std::vector<Event>{{at(16ms), 3}}));
}

TEST(PacketFeedback, GivesUntimedEventsTheMomentOfTheirArrival) {
    const std::vector<Taken> taken = carried(true);
    ASSERT_EQ(taken.size(), 3U);
    EXPECT_EQ(taken[0].known, (TimeSpan{at(0ms), at(16ms) + 1ns}));
    EXPECT_EQ(taken[0].events, (std::vector<Event>{{at(16ms), 1}, {at(16ms), 3}}));
    EXPECT_EQ(taken[1].known, (TimeSpan{at(16ms) + 1ns, at(21ms) + 1ns}));
    EXPECT_EQ(taken[1].events, (std::vector<Event>{{at(21ms), 3}}));
    EXPECT_FALSE(taken[1].gap);
}

TEST(PacketFeedback, KnowsTheLengthOfWhatIsLostOfUntimedEvents) {
    const std::vector<Taken> taken = carried(true, true);
    ASSERT_EQ(taken.size(), 2U);
    EXPECT_EQ(taken[1].gap, (TimeSpan{at(16ms) + 1ns, at(21ms) + 1ns}));
    // At 26 ms it comes, and for as long as the link takes it waits for the one before it.
    EXPECT_EQ(taken[1].known, (TimeSpan{at(21ms) + 1ns, at(28ms) + 1ns}));
    EXPECT_EQ(taken[1].events, (std::vector<Event>{{at(28ms), 3}}));
}

}  // namespace
}  // namespace afferent
