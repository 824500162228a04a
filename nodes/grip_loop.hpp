// The loop that moves a hand: it steps the controller, decides what the grip may do, and commands the motor.
// It waits for nobody.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "afferent/nodes/grip_inbox.hpp"
#include "afferent/nodes/guarded_hand.hpp"
#include "afferent/nodes/hand_device.hpp"
#include "afferent/nodes/pacer.hpp"
#include "afferent/nodes/step_lateness.hpp"
#include "afferent/runtime/grip_guard.hpp"
#include "afferent/runtime/latest.hpp"

namespace afferent {

// The state of the loop, published after everything it does.
struct GripReport {
    bool begun = false;
    bool at_end = false;  // of the scene
    bool stopped = false;
    TimePoint at = scene_start;  // everything before this time has been done
    std::uint64_t next_step = 0;
    std::optional<TimePoint> next_scan;
    GripStep last_step{};
    GripState state = GripState::safe;
    GripCause cause;
    std::uint64_t sessions = 0;  // that have opened, as far as the loop has heard
    bool spent = false;          // only another session than the last of these can re-arm the hand
    std::uint64_t freezes = 0;
    std::uint64_t safe_states = 0;
    std::uint64_t late_packets = 0;
    std::uint64_t dropped_packets = 0;  // because too many waited to act
    std::uint64_t dropped_scans = 0;
    std::uint64_t lost_steps = 0;  // which found no room in the records
    std::optional<Pacer> pacer;    // nothing before it has begun, and in virtual time
    struct Lateness {
        Duration p50{};
        Duration p99{};
        Duration max{};
    } step_lateness;
};

// A scan for the coprocessor, where the samples are the hand's.
struct FeedScan {
    TimePoint time;
    Address first = 0;
    std::vector<double> forces_n;
};

// It has no thread of its own: its owner calls poll(). After construction it allocates nothing, takes no
// lock, and touches no file, socket or terminal: input and output pass through queues that drop and count.
// The hand is safe until a session's packets have arrived (GripGuard), and once begun it steps to the scene's
// end, whatever becomes of the session.
class GripLoop {
  public:
    struct Options {
        // Virtual time: nothing is done beyond the time given to allow(), and the grip is always operating.
        bool lockstep = false;
        // Messages are passed on to the records.
        bool keeps_messages = false;
        // The motor: called with each step as soon as it is done. Must neither wait nor throw.
        std::function<void(const ControllerStep&)> motor = [](const auto&) {};
        // A hand on a line, which is commanded with each step, too. Outlives the loop. Null: there is none.
        HandDevice* device = nullptr;
        // A scan for the coprocessor is there. Must neither wait nor throw.
        std::function<void()> fed = [] {};
    };
    GripLoop(const Plan& plan, std::unique_ptr<HandEnd> link_end, Options options, MonotonicClock clock);

    // Takes the input that has come, and does everything that is due. Returns when the next thing is due, as
    // far as that depends on the clock. `each` is called after each thing done.
    template <class Each>
    MonotonicTime poll(const Each& each) {
        take_inputs();
        MonotonicTime wake{};
        while (do_next(wake)) each();
        return wake;
    }
    MonotonicTime poll() {
        return poll([] {});
    }
    // Takes the input that has come, and does nothing else.
    void take_inputs();
    // In virtual time everything up to then may be done.
    void allow(TimePoint time) noexcept { allowed_ = time; }

    // For other threads than that of poll(): the one that runs the link, and the one that writes.
    GripInbox& inbox() noexcept { return inbox_; }
    const GripInbox& inbox() const noexcept { return inbox_; }
    const GripReport& report() { return report_.read(); }
    SlotRing<FeedScan>& scans() noexcept { return scans_; }
    HandRecords& records() noexcept { return records_; }
    const HandRecords& records() const noexcept { return records_; }
    // Why no more scans are taken, if so; the steps go on.
    std::optional<std::string> failure() const;

    // Before anything is done.
    const HandEnd& link_end() const noexcept { return hand_.link_end(); }

  private:
    void take(GripInput& input);
    void receive(GripInput& input);
    bool do_next(MonotonicTime& wake);
    void follow_guard(MonotonicTime now);
    void feed(const Scan& scan);
    void tell();
    void look_at_lateness();

    Options options_;
    MonotonicClock clock_;
    TimePoint end_;  // of the scene
    HandRecords records_;
    GuardedHand hand_;
    GripGuard guard_;
    std::optional<Pacer> pacer_;
    StepLateness lateness_;
    bool stepped_ = false;  // what is being done is a step
    LostSpan lost_;         // because too many packets waited to act
    TimePoint allowed_ = TimePoint::min();

    GripInbox inbox_;
    SlotRing<FeedScan> scans_;
    Latest<GripReport> report_;
    GripReport told_;
    std::atomic<const SampleSource*> refused_by_{nullptr};  // a scan
};

}  // namespace afferent
