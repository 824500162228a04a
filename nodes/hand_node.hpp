// A hand on a link: accepts coprocessors, decodes their events, drives the motor, and enters the safe state
// without them. Included by programs that run the hand of a scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "afferent/io/links/asio_forward.hpp"
#include "afferent/nodes/node_options.hpp"
#include "afferent/nodes/observer.hpp"
#include "afferent/runtime/monotonic_time.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

class HandDevice;
class HandSession;
class Listener;
class Pacer;
struct GripReport;
struct Plan;

// The node has no event loop of its own: its owner runs the io_context and calls poll().
//
//     while (const auto wake = node->poll()) {
//         io.restart();
//         io.run_one_until(*wake);
//         io.poll();
//     }
//
// After a session breaks off the node accepts the next. Between sessions the hand goes on in real time,
// frozen and then safe; in lockstep it waits. A GripLoop steps the hand and drives its motor: with
// `NodeOptions::grip_thread` on a thread of its own, which the link cannot delay; otherwise poll() runs it.
// Nothing throws but the observer.
class HandNode {
  public:
    // Opens the scene's hand in real time, on the scene's link. `io` must outlive the node. The error names
    // the table, output, recording or link that cannot be opened. Throws SceneError if the scene is invalid.
    static Result<std::unique_ptr<HandNode>> open(const Scene& scene, boost::asio::io_context& io,
                                                  const NodeOptions& options, Observer observer);
    // The same with a link and clock of the caller's. The plan must have a controller and outlive the node.
    static Result<std::unique_ptr<HandNode>> open(const Plan& plan, std::unique_ptr<Listener> listener,
                                                  const NodeOptions& options, Observer observer,
                                                  MonotonicClock clock);
    // The same with a hand of the caller's (hand_device.hpp) in place of the one on the scene's line. Its
    // scans have the forces of all of the scene's elements, and their times are of `clock`.
    static Result<std::unique_ptr<HandNode>> open(const Plan& plan, std::unique_ptr<Listener> listener,
                                                  const NodeOptions& options, Observer observer,
                                                  MonotonicClock clock, std::unique_ptr<HandDevice> device);
    virtual ~HandNode() = default;

    // Begins to listen for coprocessors.
    virtual void start() = 0;
    // Does everything that is due. Returns the latest time for the next call, if no input arrives before it;
    // empty if the node has ended.
    virtual std::optional<MonotonicTime> poll() = 0;
    // Ends the session and the node.
    virtual void interrupt() = 0;
    // Passes on the user's acknowledgement, which re-arms a safe hand if the scene's hand.rearm is by_user.
    virtual void acknowledge() = 0;
    // Has the hand on the scene's line take the zero of its sensors, which nothing may touch now.
    virtual void take_zero() = 0;
    // Writes pending records to outputs and recording. With `NodeOptions::writes`, poll() does so.
    virtual void write() = 0;
    // The number of records that wait for write().
    virtual std::size_t waiting_records() const noexcept = 0;
    // Messages about the outputs, for people.
    virtual std::vector<std::string> output_notices() const = 0;
    // How many steps the outputs have lost. To be called on the thread that calls write().
    virtual std::uint64_t lost_steps() const noexcept = 0;
    // Completes the outputs and the recording, if any. To be called once, at the end.
    virtual Result<void> close() = 0;

    // Why the node ended early; empty if it did not.
    virtual const std::optional<std::string>& failure() const noexcept = 0;
    // The address on which it listens, as text.
    virtual std::string address() const = 0;

    virtual const Plan& plan() const noexcept = 0;
    // The scene time up to which everything is done.
    virtual TimePoint at() const noexcept = 0;
    // Null between sessions.
    virtual const HandSession* session() const noexcept = 0;
    // Empty before the hand has begun, and in lockstep.
    virtual const std::optional<Pacer>& pacer() const noexcept = 0;
    // The last report of the loop that steps the hand.
    virtual const GripReport& grip() const noexcept = 0;
    // Counts over all sessions (hand_report.hpp).
    struct Report;
    virtual Report report() const = 0;
    // Messages about the source of the EMG, for people.
    virtual const std::vector<std::string>& said_of_emg() const noexcept = 0;
};

}  // namespace afferent
