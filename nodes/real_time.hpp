// A real-time priority for a thread that must not wait for others.
#pragma once

#include <pthread.h>
#include <sched.h>

#include <thread>

namespace afferent {

// SCHED_FIFO, the lowest priority of it. False: the system does not permit it to this user.
inline bool give_real_time_priority(std::thread& thread) noexcept {
    const sched_param priority{.sched_priority = sched_get_priority_min(SCHED_FIFO)};
    return pthread_setschedparam(thread.native_handle(), SCHED_FIFO, &priority) == 0;
}

}  // namespace afferent
