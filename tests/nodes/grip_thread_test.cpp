// A hand whose loop has a thread of its own, in real time.
#include "afferent/nodes/grip_thread.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <stdexcept>
#include <thread>

#include "tests/nodes/two_nodes.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

class ThreadedHand {
  public:
    explicit ThreadedHand(const std::string& scene, std::function<void()> fed = {})
        : plan(make_plan(Scene::from_text(scene), Commands::wanted)) {
        hand = value_or_throw(HandNode::open(plan, links.listener(),
                                             {.grip_thread = true,
                                              .motor =
                                                  [this](const ControllerStep&) {
                                                      ++commands;
                                                      while (held_up) std::this_thread::sleep_for(1ms);
                                                  },
                                              .fed = std::move(fed)},
                                             {}, clock));
        hand->start();
    }
    void start_coprocessor() {
        coprocessor = value_or_throw(CoprocessorNode::open(plan, links.connector(), {}, {}, clock));
        coprocessor->start();
    }

    // Polls both nodes until then; throws after twenty seconds.
    template <class Condition>
    void poll_until(Condition condition) {
        wait_until(condition, [this] {
            links.deliver();
            const auto wake = hand->poll();
            if (wake) longest_wait = std::max<Duration>(longest_wait, *wake - clock());
            if (coprocessor) coprocessor->poll();
        });
    }
    // Polls nobody.
    template <class Condition>
    void leave_alone_until(Condition condition) {
        wait_until(condition, [] {});
    }

    const MonotonicClock clock = std::chrono::steady_clock::now;
    MemoryLinks links{clock};
    const Plan plan;
    std::atomic<int> commands = 0;
    std::atomic<bool> held_up = false;  // the loop's thread
    Duration longest_wait{};            // that a poll of the hand has allowed
    std::unique_ptr<CoprocessorNode> coprocessor;
    std::unique_ptr<HandNode> hand;

  private:
    template <class Condition, class Each>
    void wait_until(Condition condition, Each each) {
        for (const MonotonicTime limit = clock() + 20s; !condition();) {
            if (clock() > limit) throw std::runtime_error("waited in vain");
            each();
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    }
};

TEST(GripThread, StepsAndGoesSafeWhileNobodyPollsTheNode) {
    ThreadedHand it(grasp("", 100));
    it.start_coprocessor();
    it.poll_until([&] { return it.hand->report().state == GripState::operating; });
    const int before = it.commands;
    const std::uint64_t safe_before = it.hand->report().safe_states;
    it.leave_alone_until([&] { return it.commands >= before + 300; });
    it.poll_until([&] { return it.hand->grip().next_step > 300; });
    EXPECT_GT(it.hand->report().safe_states, safe_before) << "the coprocessor was not heard for 300 ms";
    it.hand->interrupt();
    it.poll_until([&] { return !it.hand->poll(); });
    const int last = it.commands;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_EQ(it.commands, last) << "its thread has ended";
}

// What is told of a session that has made the hand safe is not told of the next, which the loop has not heard
// of yet.
TEST(GripThread, DoesNotAnswerForTheSessionBefore) {
    ThreadedHand it(press("", 100));
    it.start_coprocessor();
    it.poll_until([&] { return it.hand->report().state == GripState::operating; });
    it.links.set_carries([](const proto::Envelope*) { return false; });
    it.poll_until([&] { return it.hand->grip().spent; });
    it.held_up = true;
    it.links.set_carries([](const proto::Envelope*) { return true; });
    it.poll_until([&] { return it.coprocessor->report().sessions == 2; });
    // Statuses come every 50 ms.
    const MonotonicTime end = it.clock() + 120ms;
    it.poll_until([&] { return it.clock() > end; });
    EXPECT_EQ(it.hand->grip().sessions, 1U) << "nobody else hears of it in the loop's place";
    it.held_up = false;
    it.poll_until([&] { return it.hand->report().state == GripState::operating; });
    EXPECT_EQ(it.coprocessor->report().sessions, 2U);
}

// A millisecond is how often a node that is not told of scans has to look for them.
TEST(GripThread, IsAskedForScansWhereNobodyTellsOfThem) {
    ThreadedHand it(grasp("", 100));
    it.poll_until([&] { return it.longest_wait > 2ms; });
    it.start_coprocessor();
    it.poll_until([&] { return it.hand->grip().begun; });
    it.longest_wait = {};
    it.poll_until([&] { return it.hand->report().feed_bytes > 1000; });
    EXPECT_LE(it.longest_wait, 1ms);

    std::atomic<int> scans = 0;
    ThreadedHand told(grasp("", 100), [&] { ++scans; });
    told.start_coprocessor();
    told.poll_until([&] { return told.hand->grip().begun; });
    told.longest_wait = {};
    told.poll_until([&] { return told.hand->report().feed_bytes > 1000 && told.longest_wait > 2ms; });
    EXPECT_GT(scans, 0);

    ThreadedHand without(press("", 100));
    without.start_coprocessor();
    without.poll_until([&] { return without.hand->grip().begun; });
    without.longest_wait = {};
    without.poll_until([&] { return without.longest_wait > 2ms; });
}

TEST(GripThread, IsLeftOutInLockstep) {
    TwoNodes two(grasp());
    two.start({.lockstep = true, .grip_thread = true}, {.lockstep = true});
    two.run_to_the_end();
    EXPECT_EQ(two.hand.steps.size(), 2000U);
    EXPECT_FALSE(two.hand.node->report().real_time_priority);
}

}  // namespace
}  // namespace afferent
