// The outputs of a scene: what leaves it, while it runs, for the world.
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "afferent/nodes/command_file.hpp"
#include "afferent/nodes/live_events.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// What an output provides. All calls come from one thread; none throws.
//
//   thread                   Which of a hand's threads that is, and with it what a call may cost
//                            (output_thread.hpp).
//   Described                Its struct of the scene.
//   open(scene, described, full_pipe)
//                            An open one, or why it cannot be.
//   observe(span, events)    The events of the span, sorted, as they become known; of what no span covers
//                            nothing is known. A span may come in parts.
//   take(step)               Each step of the controller.
//   close()                  Completes the output and returns its first error, if there was one.
//   lost()                   What it did not take because it could not keep up; final after close().
//   notice()                 What people should know of it now, such as a named pipe that nobody reads;
//   mostly nothing.
template <class O>
concept Output = requires(O output, const O& constant, const TimeSpan& span, std::span<const Event> events,
                          const ControllerStep& step, const Scene& scene,
                          const typename O::Described& described, FullPipe full_pipe) {
    { O::open(scene, described, full_pipe) } -> std::same_as<Result<O>>;
    { O::thread } -> std::convertible_to<OutputThread>;
    { output.observe(span, events) } -> std::same_as<void>;
    { output.take(step) } -> std::same_as<void>;
    { output.close() } -> std::same_as<Result<void>>;
    { constant.lost() } -> std::same_as<OutputLosses>;
    { constant.notice() } -> std::same_as<std::optional<std::string>>;
};

template <Output... O>
using OutputList = std::variant<O...>;

// To add an output, add its header above and its name here.
using AnyOutput = OutputList<CommandFile, LiveEvents>;

class Outputs {
  public:
    // Opens those of the scene's outputs that run on this thread; without one, all. Commands for a named pipe
    // that nobody reads wait, or are lost and counted.
    static Result<Outputs> open(const Scene& scene, std::optional<OutputThread> thread = {},
                                FullPipe full_pipe = FullPipe::wait);
    Outputs() = default;

    bool empty() const noexcept { return outputs_.empty(); }
    void observe(const TimeSpan& span, std::span<const Event> events) {
        for (AnyOutput& output : outputs_) std::visit([&](auto& one) { one.observe(span, events); }, output);
    }
    void take(const ControllerStep& step) {
        for (AnyOutput& output : outputs_) std::visit([&](auto& one) { one.take(step); }, output);
    }
    // The first error of all of them.
    Result<void> close();
    // The largest losses of an output; final after close().
    OutputLosses lost() const noexcept;
    std::vector<std::string> notices() const;

  private:
    std::vector<AnyOutput> outputs_;
};

}  // namespace afferent
