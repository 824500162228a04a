// Keeps a process in memory: a step of a hand is not to wait for a page that was moved to the disk.
#pragma once

namespace afferent {

// Locks all memory that the process has and will have, as it comes into use. False: the system does not
// permit this to the user without a limit (ulimit -l), at which a lock would let the program run out of
// memory.
bool lock_memory() noexcept;

}  // namespace afferent
