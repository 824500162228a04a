// A coprocessor on a link: looks for the hand, encodes samples, and sends the events in packets. Included by
// programs that run the coprocessor of a scene.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "afferent/io/links/asio_forward.hpp"
#include "afferent/nodes/node_options.hpp"
#include "afferent/nodes/observer.hpp"
#include "afferent/runtime/monotonic_time.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/runtime/scan.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

class ChipDevice;
class Connector;
class CoprocessorSession;
class CoprocessorEnd;
class Pacer;
struct Plan;

// Its owner drives it like a HandNode, with a work guard on `io`: between two attempts to connect there is
// nothing else to wait for. If the connection to the hand is lost, the node tries to reconnect for
// the scene's connect_s; meanwhile the neurons go on in real time, and wait in lockstep. Nothing throws but
// the observer.
class CoprocessorNode {
  public:
    // Opens the scene's coprocessor in real time, on the scene's link. `io` must outlive the node. The error
    // names the table, recording or link that cannot be opened. Throws SceneError if the scene is invalid.
    static Result<std::unique_ptr<CoprocessorNode>> open(const Scene& scene, boost::asio::io_context& io,
                                                         const NodeOptions& options, Observer observer);
    // The same with a link and clock of the caller's. The plan must outlive the node. `standard_input` reads
    // the samples of scenes whose source is standard input. A scene whose source is a chip opens the chip's
    // device; it is not run in lockstep, and poll() has to be called every millisecond.
    using ReadInput = std::function<std::size_t(std::span<char> buffer)>;
    static Result<std::unique_ptr<CoprocessorNode>> open(const Plan& plan,
                                                         std::unique_ptr<Connector> connector,
                                                         const NodeOptions& options, Observer observer,
                                                         MonotonicClock clock, ReadInput standard_input = {});
    // With a line of the caller's to the chip that is the scene's source.
    static Result<std::unique_ptr<CoprocessorNode>> open(const Plan& plan,
                                                         std::unique_ptr<Connector> connector,
                                                         const NodeOptions& options, Observer observer,
                                                         MonotonicClock clock,
                                                         std::unique_ptr<ChipDevice> chip);
    virtual ~CoprocessorNode() = default;

    // Begins to connect to the hand.
    virtual void start() = 0;
    // Does everything that is due. Returns the latest time for the next call, if no input arrives before it;
    // empty if the node has ended.
    virtual std::optional<MonotonicTime> poll() = 0;
    // Takes the forces of all elements of one patch, in N, if the scene's source is pushed {}. Scans must
    // arrive in order of time. An error describes an invalid scan, which is ignored.
    virtual Result<void> push(const Scan& scan) = 0;
    // Sends all events, ends the session, and ends the node.
    virtual void interrupt() = 0;
    // The same, and tells the peer the owner's reason.
    virtual void fail(const std::string& text) = 0;
    // Completes the recording, if any. To be called once, at the end.
    virtual Result<void> close() = 0;

    // Why the node ended early; empty if it did not.
    virtual const std::optional<std::string>& failure() const noexcept = 0;

    virtual const Plan& plan() const noexcept = 0;
    // The scene time up to which everything is done.
    virtual TimePoint at() const noexcept = 0;
    virtual CoprocessorEnd& link_end() noexcept = 0;
    virtual const CoprocessorEnd& link_end() const noexcept = 0;
    // Null between sessions.
    virtual const CoprocessorSession* session() const noexcept = 0;
    // Empty before the neurons have begun, and in lockstep.
    virtual const std::optional<Pacer>& pacer() const noexcept = 0;
    // Counts over all sessions (coprocessor_report.hpp).
    struct Report;
    virtual Report report() const = 0;
};

}  // namespace afferent
