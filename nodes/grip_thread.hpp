// Runs the loop that closes a hand on a thread of its own.
#pragma once

#include <atomic>
#include <thread>

#include "afferent/nodes/grip_loop.hpp"

namespace afferent {

// With a real-time priority (SCHED_FIFO) where the system permits it to this user. The thread ends when the
// loop has been told to stop. The loop outlives this.
class GripThread {
  public:
    explicit GripThread(GripLoop& loop);
    // Waits until the loop has noticed that it was told to stop.
    ~GripThread();
    bool has_priority() const noexcept { return has_priority_; }
    GripThread(const GripThread&) = delete;
    GripThread& operator=(const GripThread&) = delete;

  private:
    std::atomic<bool> ends_{false};
    std::thread thread_;
    bool has_priority_ = false;
};

}  // namespace afferent
