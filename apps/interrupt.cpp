#include "afferent/apps/interrupt.hpp"

#include <algorithm>
#include <csignal>
#include <thread>

namespace afferent {
namespace {

volatile std::sig_atomic_t end_asked = 0;

extern "C" void on_interrupt(int signal) {
    end_asked = 1;
    std::signal(signal, SIG_DFL);
}

}  // namespace

void catch_interrupts() {
    std::signal(SIGINT, on_interrupt);
    std::signal(SIGTERM, on_interrupt);
#ifdef SIGHUP
    // Under nohup it stays ignored.
    if (std::signal(SIGHUP, on_interrupt) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
#endif
#ifdef SIGPIPE
    std::signal(SIGPIPE, SIG_IGN);  // writing to a peer that has gone returns an error
#endif
}

bool interrupted() noexcept { return end_asked != 0; }

bool sleep_until(std::chrono::steady_clock::time_point time) {
    using Clock = std::chrono::steady_clock;
    constexpr auto longest_nap = std::chrono::milliseconds(50);
    while (!interrupted() && Clock::now() < time)
        std::this_thread::sleep_until(std::min(time, Clock::now() + longest_nap));
    return !interrupted();
}

}  // namespace afferent
