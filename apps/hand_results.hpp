// Writes what a hand does to files on a thread of its own, so that neither the hand nor its link waits for
// them.
#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "afferent/apps/recorder.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/nodes/hand_node.hpp"
#include "afferent/runtime/slot_ring.hpp"

namespace afferent {

class HandResults {
  public:
    // Where `out` is empty, only the force error is kept. Throws Failure.
    HandResults(const Plan& plan, std::string out, FullPipe full_pipe);
    ~HandResults();
    HandResults(const HandResults&) = delete;
    HandResults& operator=(const HandResults&) = delete;

    // For the node's callbacks: step and starting_over are called as the steps are written, the others from
    // the link.
    void step(const ControllerStep& step);
    void starting_over();
    void events(std::span<const Event> events);
    void about_to_start_over(const HandNode& node);

    // From here on a thread writes what the node does. Otherwise the node writes by itself.
    void start_thread(HandNode& node);

    // After the node has ended: completes all files, and adds to the summary what was not written. False:
    // they have taken nothing for two seconds; then the thread cannot be ended, and the process must be.
    bool finish(HandNode& node, Summary& summary);
    // The first thing that could not be written.
    const std::optional<std::string>& failure() const noexcept { return failure_; }
    // Draws the pictures, and returns why one could not be drawn.
    std::vector<std::string> draw_pictures();

  private:
    struct EventsOfPacket {
        std::vector<Event> events;
    };

    void write_some(HandNode& node);
    void complete(HandNode& node);
    void start_recorder();
    void guarded(const std::function<void()>& write);

    const Plan& plan_;
    std::string out_;
    FullPipe full_pipe_;
    std::vector<std::unique_ptr<Recorder>> recorders_;  // the last: of what the hand does now
    int starts_ = 0;
    SlotRing<EventsOfPacket> events_;
    std::mutex mutex_;                // of what the link's thread leaves for this one
    std::deque<Summary> before_;      // of what was before each start
    std::optional<Summary> summary_;  // of all: there is nothing left to come
    std::optional<std::string> failure_;
    std::thread thread_;
    std::atomic<std::uint64_t> progress_{0};
    std::atomic<bool> ends_{false};
    std::atomic<bool> done_{false};
};

}  // namespace afferent
