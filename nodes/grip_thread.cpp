#include "afferent/nodes/grip_thread.hpp"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <chrono>

namespace afferent {
namespace {

// The longest sleep of the loop while nothing is due; input waits for as long.
constexpr std::chrono::milliseconds longest_sleep{1};

}  // namespace

GripThread::GripThread(GripLoop& loop)
    : thread_([this, &loop] {
          while (!ends_.load(std::memory_order_relaxed)) {
              const MonotonicTime wake = loop.poll();
              std::this_thread::sleep_until(std::min(wake, std::chrono::steady_clock::now() + longest_sleep));
          }
          loop.take_inputs();
      }) {
    const sched_param priority{.sched_priority = sched_get_priority_min(SCHED_FIFO)};
    has_priority_ = pthread_setschedparam(thread_.native_handle(), SCHED_FIFO, &priority) == 0;
}

GripThread::~GripThread() {
    ends_.store(true, std::memory_order_relaxed);
    thread_.join();
}

}  // namespace afferent
