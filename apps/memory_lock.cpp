#include "afferent/apps/memory_lock.hpp"

#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

namespace afferent {

bool lock_memory() noexcept {
    rlimit limit{};
    const bool limited = ::getrlimit(RLIMIT_MEMLOCK, &limit) != 0 || limit.rlim_cur != RLIM_INFINITY;
    if (limited && ::geteuid() != 0) return false;
    return ::mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0;
}

}  // namespace afferent
