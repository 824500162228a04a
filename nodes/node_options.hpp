// How a node keeps time, and what it writes.
#pragma once

#include <chrono>
#include <filesystem>

namespace afferent {

// How often a node polls its session.
inline constexpr std::chrono::milliseconds look_after_period{10};

struct NodeOptions {
    // Virtual time, carried by the messages, in place of the clock.
    bool lockstep = false;
    // The file of a recording; empty: none is made.
    std::filesystem::path record = {};
    // A hand steps on a thread of its own, which nothing else holds up. Not in lockstep.
    bool grip_thread = false;
    // A hand writes its outputs and its recording as it polls. Otherwise its owner calls write() on a thread
    // of its own, so that slow outputs hold up nothing else.
    bool writes = true;
};

}  // namespace afferent
