// The time that a thread has computed: what others make it wait does not count.
#pragma once

#include <ctime>

namespace afferent::bench {

inline double thread_seconds() {
    timespec time;
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace afferent::bench
