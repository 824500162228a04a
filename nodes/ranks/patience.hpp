// Waiting for another rank, which may have died.
#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <thread>

namespace afferent::ranks {

using Clock = std::chrono::steady_clock;

struct Patience {
    // How long a rank is waited for.
    Clock::duration longest = std::chrono::minutes(1);
    // Whether this program has been told to end, as it is when a rank has died; it then waits for no more
    // than what is on its way.
    std::function<bool()> interrupted = [] { return false; };
    Clock::duration once_interrupted = std::chrono::milliseconds(300);
};

// Waits until ready(), and leaves the processor to others while it does. False if that took too long.
template <class Ready>
bool wait(const Patience& patience, Ready&& ready) {
    if (ready()) return true;
    const auto begin = Clock::now();
    auto limit = begin + patience.longest;
    for (bool interrupted = false;;) {
        if (ready()) return true;
        const auto now = Clock::now();
        if (!interrupted && patience.interrupted()) {
            interrupted = true;
            limit = std::min(limit, now + patience.once_interrupted);
        }
        if (now > limit) return false;
        // Most waits are short, and sleeping takes longer than they do.
        if (now < begin + std::chrono::milliseconds(1))
            std::this_thread::yield();
        else
            std::this_thread::sleep_for(std::chrono::microseconds(50));
    }
}

}  // namespace afferent::ranks
