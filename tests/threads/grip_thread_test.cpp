// A loop on a thread of its own, with a link's thread and a writer's beside it; for ThreadSanitizer above
// all.
#include "afferent/nodes/grip_thread.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "afferent/nodes/hand_writer.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

using Clock = std::chrono::steady_clock;

Reception packet_of(TimePoint begin, TimePoint end, std::span<const Event> events) {
    Reception reception;
    reception.known = {begin, end};
    reception.events = events;
    return reception;
}

constexpr const char* reaching = R"(
    duration_s: 60 link { tcp {} freeze_ms: 300 safe_ms: 4000 }
    hand { user { close_at_s: 0.1 close_for_s: 1.8 effort: 0.7 } object { distance_mm: 500 } })";

TEST(GripThread, StepsBesideALinkAndAWriter) {
    const Plan plan = make_plan(Scene::from_text(reaching), Commands::wanted);
    std::atomic<int> commands{0};
    GripLoop::Options options;
    options.keeps_messages = true;
    options.motor = [&](const ControllerStep&) { ++commands; };
    GripLoop loop(plan, value_or_throw(HandEnd::open(plan)), options, Clock::now);
    int written = 0;
    std::atomic<bool> ends{false};
    std::thread writer([&] {
        Observer listener;
        listener.step = [&](const auto&) { ++written; };
        HandWriter out({}, listener);
        while (!ends) {
            out.write(loop.records());
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        out.write(loop.records());
    });
    GripState state = GripState::safe;
    std::uint64_t scans = 0;
    {
        const GripThread thread(loop);
        const MonotonicTime began = Clock::now();
        loop.inbox().opened(began, {});
        loop.inbox().begin(began, scene_start, nullptr);
        // However busy the machine is: until it operates, and some more.
        TimePoint known = scene_start;
        const auto has_done_enough = [&] {
            return state == GripState::operating && scans > 10 && commands > 50;
        };
        for (int k = 0; k < 10'000 && !has_done_enough(); ++k) {
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
            const MonotonicTime now = Clock::now();
            const TimePoint end = scene_start + (now - began);
            const std::vector<Event> events{{known, 0}};
            proto::Envelope packet;
            packet.set_position(static_cast<std::uint32_t>(k) + 1);
            loop.inbox().receive(packet_of(known, end, events), {}, now);
            loop.inbox().packet(packet);
            known = end;
            state = loop.report().state;
            while (loop.scans().next()) {
                loop.scans().pop();
                ++scans;
            }
        }
        loop.inbox().ended(Clock::now(), std::nullopt);
        loop.inbox().stop();
    }
    ends = true;
    writer.join();
    EXPECT_EQ(state, GripState::operating);
    EXPECT_TRUE(loop.report().stopped);
    EXPECT_GT(scans, 10U);
    EXPECT_GT(commands, 50);
    EXPECT_EQ(static_cast<std::uint64_t>(written) + loop.report().lost_steps,
              static_cast<std::uint64_t>(commands));
}

}  // namespace
}  // namespace afferent
