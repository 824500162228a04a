// The outputs that a scene names: they take the steps of the hand's controller.
#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <variant>
#include <vector>

#include "afferent/nodes/command_file.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// What an output provides:
//
//   take(step)      Takes each step of the controller, and does not throw: an error waits for close().
//   close()         Completes the output and returns its first error, if there was one.
//   unread_pipe()   The named pipe that it writes to, while nobody reads it; otherwise nothing.
//   lost_steps()    How many steps that pipe did not take, final after close(); otherwise 0.
template <class O>
concept TakesSteps = requires(O output, const O& constant, const ControllerStep& step) {
    { output.take(step) } -> std::same_as<void>;
    { output.close() } -> std::same_as<Result<void>>;
    { constant.unread_pipe() } -> std::same_as<std::optional<std::filesystem::path>>;
    { constant.lost_steps() } -> std::same_as<std::uint64_t>;
};

template <TakesSteps... O>
using StepOutputList = std::variant<O...>;

// To add an output, add its header above and its name here, and an open_output() for it in outputs.cpp.
using StepOutput = StepOutputList<CommandFile>;

class StepOutputs {
  public:
    // Opens the plan's outputs, in its order.
    static Result<StepOutputs> open(const Plan& plan, FullPipe full_pipe = FullPipe::wait);
    StepOutputs() = default;

    void take(const ControllerStep& step) {
        for (StepOutput& output : outputs_) std::visit([&](auto& one) { one.take(step); }, output);
    }
    // The first error of all of them.
    Result<void> close();
    std::size_t size() const noexcept { return outputs_.size(); }
    // The pipes that nobody reads.
    std::vector<std::filesystem::path> unread() const;
    // The largest number of steps that one of them lost; final after close().
    std::uint64_t lost_steps() const noexcept;

  private:
    std::vector<StepOutput> outputs_;
};

}  // namespace afferent
