// Options of a node: its clock, its threads and its recording. Included by programs that run a node.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>

#include "afferent/engine/controller_step.hpp"

namespace afferent {

// How often a node polls its session.
inline constexpr std::chrono::milliseconds look_after_period{10};

struct NodeOptions {
    // Whether messages carry a virtual time that replaces the clock.
    bool lockstep = false;
    // The file to record to; empty for none.
    std::filesystem::path record = {};
    // Whether a hand steps on a thread of its own, which links and files cannot delay. Ignored in lockstep.
    bool grip_thread = false;
    // Whether poll() of a hand writes outputs and recording. Otherwise its owner calls write() on another
    // thread, so that slow outputs delay nothing else.
    bool writes = true;
    // The motor of a hand: called with each step as soon as it is computed, on the thread that steps the
    // hand. Must neither block nor throw.
    std::function<void(const ControllerStep&)> motor = [](const auto&) {};
    // Called by a hand on the thread that steps it, when a scan for the coprocessor waits for poll(). Must
    // neither block nor throw. If empty, poll() must be called every millisecond while there are scans.
    std::function<void()> fed = {};
};

}  // namespace afferent
