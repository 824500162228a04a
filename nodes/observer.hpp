// The callbacks of a running scene. Included by programs that watch a run, a replay or a node.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "afferent/engine/controller_step.hpp"
#include "afferent/runtime/event.hpp"
#include "afferent/runtime/scan.hpp"

namespace afferent {

namespace proto {
class Envelope;
}
struct Reception;

// All callbacks are optional. They are called in the order of what they report, from within the call that
// causes it: for a node, poll() or a handler of the io_context. Exceptions are step, starting_over and safe
// of a hand, which HandNode::write() calls, possibly on another thread.
struct Observer {
    // Events, sorted: at the coprocessor when computed, or when they leave its bus; at the hand when their
    // packet arrives.
    std::function<void(std::span<const Event>)> events = [](auto) {};
    // Packets were lost: the events of this span will never be known. Called before the events that follow
    // it.
    std::function<void(const TimeSpan&)> gap = [](const auto&) {};
    // Each step of the controller.
    std::function<void(const ControllerStep&)> step = [](const auto&) {};
    // A node is about to restart at another time of the scene; its report still covers the time before.
    // Followed by starting_over before the first step there.
    std::function<void()> about_to_start_over = [] {};
    std::function<void()> starting_over = [] {};
    // The grip has entered the safe state, with the reason. The text is safe to print.
    std::function<void(const std::string&)> safe = [](const auto&) {};
    // Progress of the session, as text.
    std::function<void(const std::string&)> session = [](const auto&) {};
    // Samples, when the neurons receive them.
    std::function<void(const Scan&)> scan = [](const auto&) {};
    // Each packet when it is complete, if the link carries packets.
    std::function<void(const proto::Envelope&)> packet = [](const auto&) {};
    // The events of each span between two deadlines, if the link passes events without packets.
    std::function<void(const Reception&)> span = [](const auto&) {};
};

}  // namespace afferent
