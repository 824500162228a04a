// SIGINT (Ctrl-C), SIGTERM and SIGHUP (the terminal is gone): the first lets the command end cleanly, the
// second ends the program at once.
#pragma once

#include <chrono>

namespace afferent {

void catch_interrupts();
bool interrupted() noexcept;

// Sleeps until then, or until Ctrl-C: then false.
bool sleep_until(std::chrono::steady_clock::time_point time);

}  // namespace afferent
