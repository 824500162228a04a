// A hand and a coprocessor on links in memory, with a clock that advances when there is nothing left to do.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "afferent/nodes/chip_device.hpp"
#include "afferent/nodes/coprocessor_end.hpp"
#include "afferent/nodes/coprocessor_node.hpp"
#include "afferent/nodes/coprocessor_report.hpp"
#include "afferent/nodes/grip_loop.hpp"
#include "afferent/nodes/hand_device.hpp"
#include "afferent/nodes/hand_node.hpp"
#include "afferent/nodes/hand_report.hpp"
#include "afferent/runtime/overloaded.hpp"
#include "tests/nodes/memory_links.hpp"
#include "tests/nodes/whole_run.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {

// What a step has read out of its patches.
inline std::vector<double> readout_numbers(const ControllerStep& step) {
    std::vector<double> all;
    const Overloaded add{[&](TimePoint time) { all.push_back(seconds(time)); },
                         [&](PatchIndex patch) { all.push_back(patch.value); },
                         [&](std::uint32_t count) { all.push_back(count); },
                         [&](double value) { all.push_back(value); },
                         [&](std::optional<double> value) { all.push_back(value.value_or(-1)); }};
    for (const PatchReadout& readout : step.readouts)
        std::visit([&](const auto& row) { row.columns([&](const char*, const auto& value) { add(value); }); },
                   readout);
    return all;
}

// All numbers of a step, to compare to the bit.
inline std::vector<double> numbers(const ControllerStep& step) {
    std::vector<double> all{
        seconds(step.time),  step.estimate.force_n, step.estimate.sigma_n, step.estimate.rate_hz, step.gain,
        step.closing_counts, step.effort.closing,   step.effort.opening,   step.command};
    const std::vector<double> readouts = readout_numbers(step);
    all.insert(all.end(), readouts.begin(), readouts.end());
    all.push_back(step.true_force_n.value_or(-1));
    return all;
}
using Steps = std::vector<std::vector<double>>;

struct TestHandNode {
    std::unique_ptr<HandNode> node;
    bool ended = false;
    Steps steps;
    std::vector<Event> events;
    std::vector<TimeSpan> gaps;
    std::vector<std::string> safe;
    std::vector<std::string> session;
    int about_to_start_over = 0;
    int started_over = 0;

    std::string last_of_session() const { return session.empty() ? "" : session.back(); }
};

struct TestCoprocessorNode {
    std::unique_ptr<CoprocessorNode> node;
    bool ended = false;
    std::vector<Event> events;
    std::vector<std::string> session;
    int started_over = 0;

    std::string last_of_session() const { return session.empty() ? "" : session.back(); }
};

class TwoNodes {
  public:
    // The clock of a process that has been up for a while.
    MonotonicTime now = MonotonicTime(std::chrono::hours(1));
    // The coprocessor's clock runs faster by this part.
    double drift = 0;
    MemoryLinks links{[this] { return now; }};
    TestHandNode hand;
    TestCoprocessorNode coprocessor;

    // A hand of the test's: does what is due, and says when something is again.
    std::function<MonotonicTime(MonotonicTime)> beside;

    explicit TwoNodes(const std::string& text) : TwoNodes(Scene::from_text(text)) {}
    explicit TwoNodes(const Scene& scene) : plan(make_plan(scene, Commands::wanted)) {}
    const Plan plan;

    void start_hand(const NodeOptions& options = {}) { start_hand(links.listener(), options); }
    void start_hand(std::unique_ptr<Listener> listener, const NodeOptions& options = {},
                    std::unique_ptr<HandDevice> device = nullptr) {
        hand = {};
        Observer observer;
        observer.step = [this](const ControllerStep& step) { hand.steps.push_back(numbers(step)); };
        observer.events = [this](std::span<const Event> events) {
            hand.events.insert(hand.events.end(), events.begin(), events.end());
        };
        observer.gap = [this](const TimeSpan& gap) { hand.gaps.push_back(gap); };
        observer.safe = [this](const std::string& reason) { hand.safe.push_back(reason); };
        observer.session = [this](const std::string& text) { hand.session.push_back(text); };
        observer.about_to_start_over = [this] { ++hand.about_to_start_over; };
        observer.starting_over = [this] { ++hand.started_over; };
        hand.node = value_or_throw(HandNode::open(
            plan, std::move(listener), options, std::move(observer), [this] { return now; },
            std::move(device)));
        hand.node->start();
    }

    void start_coprocessor(const NodeOptions& options = {}) { start_coprocessor(plan, options); }
    // The plan may be of another scene, and outlives the coprocessor.
    void start_coprocessor(const Plan& theirs, const NodeOptions& options = {},
                           std::unique_ptr<ChipDevice> chip = nullptr) {
        coprocessor = {};
        Observer observer;
        observer.events = [this](std::span<const Event> events) {
            coprocessor.events.insert(coprocessor.events.end(), events.begin(), events.end());
        };
        observer.session = [this](const std::string& text) { coprocessor.session.push_back(text); };
        observer.starting_over = [this] { ++coprocessor.started_over; };
        auto connector = links.connector({.limit = std::chrono::seconds(5)});
        const MonotonicClock clock = [this] { return their_time(now); };
        coprocessor.node = value_or_throw(
            chip ? CoprocessorNode::open(theirs, std::move(connector), options, std::move(observer), clock,
                                         std::move(chip))
                 : CoprocessorNode::open(theirs, std::move(connector), options, std::move(observer), clock));
        coprocessor.node->start();
    }

    void start(const NodeOptions& of_hand = {}, const NodeOptions& of_coprocessor = {}) {
        start_hand(of_hand);
        start_coprocessor(of_coprocessor);
    }
    void start_in_lockstep() { start({.lockstep = true}, {.lockstep = true}); }

    // As when its process is killed: its link closes, and it sends nothing else.
    void kill_hand() { hand.node.reset(); }
    void kill_coprocessor() { coprocessor.node.reset(); }

    // Until both have ended, or for as long.
    void run_for(Duration most) {
        const MonotonicTime end = now + most;
        for (;;) {
            links.deliver();
            MonotonicTime wake = end;
            bool any = poll(hand, wake);
            MonotonicTime their_wake = MonotonicTime::max();
            any |= poll(coprocessor, their_wake);
            if (their_wake < MonotonicTime::max()) wake = std::min(wake, our_time(their_wake));
            if (const auto arrival = links.next_arrival()) wake = std::min(wake, *arrival);
            if (beside) wake = std::min(wake, beside(now));
            if (!any || now == end) return;
            now = std::max(now, wake);
        }
    }
    void run_to_the_end() {
        run_for(std::chrono::hours(1));
        EXPECT_TRUE(!hand.node || hand.ended);
        EXPECT_TRUE(!coprocessor.node || coprocessor.ended);
    }

  private:
    static constexpr MonotonicTime began_ = MonotonicTime(std::chrono::hours(1));
    MonotonicTime their_time(MonotonicTime time) const {
        return time + std::chrono::duration_cast<Duration>(drift * Interval(time - began_));
    }
    // The first time at which the other clock shows `theirs`.
    MonotonicTime our_time(MonotonicTime theirs) const {
        MonotonicTime time =
            began_ + std::chrono::duration_cast<Duration>(Interval(theirs - began_) / (1 + drift));
        while (their_time(time) < theirs) time += Duration(1);
        return time;
    }

    template <class Node>
    static bool poll(Node& it, MonotonicTime& wake) {
        if (!it.node || it.ended) return false;
        if (const auto next = it.node->poll())
            wake = std::min(wake, *next);
        else
            it.ended = true;
        return true;
    }
};

// The results of a run of the scene in one process.
struct RunOutcome {
    Steps steps;
    std::vector<Event> events;
};
inline RunOutcome outcome_of_run(const Plan& plan) {
    RunOutcome outcome;
    Observer output;
    output.events = [&](std::span<const Event> events) {
        outcome.events.insert(outcome.events.end(), events.begin(), events.end());
    };
    output.step = [&](const ControllerStep& step) { outcome.steps.push_back(numbers(step)); };
    whole_run(plan, std::move(output));
    EXPECT_FALSE(outcome.events.empty()) << "there is nothing to compare with";
    return outcome;
}

// Without the true force, which a hand does not know whose samples are the coprocessor's.
inline Steps without_truth(Steps steps) {
    for (auto& step : steps) step.pop_back();
    return steps;
}

// A hand on a link in real time is safe until packets have come for a while. In the scenes below nobody has
// moved it by then, and only the gain differs.
inline Steps but_for_the_first_gains(Steps steps) {
    for (auto& step : steps)
        if (step[0] < 0.11) step[4] = 0;
    return without_truth(std::move(steps));
}

// The hand is simulated, and so are its sensors.
inline std::string grasp(const std::string& link = "", int duration_s = 2, const std::string& more = "") {
    return "duration_s: " + std::to_string(duration_s) + " link { tcp {} " + link + R"( }
        hand { user { close_at_s: 0.1 close_for_s: 0.8 hold_for_s: 0.6 open_for_s: 0.3 effort: 0.7 }
               object { distance_mm: 8 stiffness_n_per_mm: 1 } } )" +
           more;
}
// The same, and nothing to grasp: the gain is never turned down.
inline std::string reach(const std::string& hand = "") {
    return "duration_s: 2 link { tcp {} } hand { " + hand +
           " user { close_at_s: 0.1 close_for_s: 1.8 effort: 0.7 } object { distance_mm: 500 } }";
}
// The coprocessor has the samples.
inline std::string press(const std::string& link = "", int duration_s = 2, const std::string& more = "") {
    return "duration_s: " + std::to_string(duration_s) + " link { tcp {} " + link + R"( } source { profile {
        point { time_s: 0.1 force_n: 0 } point { time_s: 0.3 force_n: 6 } } } )" +
           more;
}

}  // namespace afferent
