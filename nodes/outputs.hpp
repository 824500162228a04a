// What else takes the steps of a hand's controller: the outputs that a scene names.
#pragma once

#include <cstdint>
#include <filesystem>
#include <variant>
#include <vector>

#include "afferent/nodes/command_file.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// To add one, add its header above, its name here, and its line in open().
using StepOutput = std::variant<CommandFile>;

class StepOutputs {
  public:
    // The plan's, in its order.
    static Result<StepOutputs> open(const Plan& plan, FullPipe full_pipe = FullPipe::wait);
    StepOutputs() = default;

    void take(const ControllerStep& step) {
        for (StepOutput& output : outputs_) std::visit([&](auto& one) { one.take(step); }, output);
    }
    // The first error of all of them.
    Result<void> close();
    std::size_t size() const noexcept { return outputs_.size(); }
    // Those that nobody reads.
    std::vector<std::filesystem::path> unread() const;
    // The most that one of them could not take; after close() for good.
    std::uint64_t lost_steps() const noexcept;

  private:
    std::vector<StepOutput> outputs_;
};

}  // namespace afferent
