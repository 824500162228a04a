#include "afferent/nodes/grip_thread.hpp"

#include <algorithm>
#include <chrono>

#include "afferent/nodes/real_time.hpp"

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
    has_priority_ = give_real_time_priority(thread_);
}

GripThread::~GripThread() {
    ends_.store(true, std::memory_order_relaxed);
    thread_.join();
}

}  // namespace afferent
