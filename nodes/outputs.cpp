#include "afferent/nodes/outputs.hpp"

#include <algorithm>

namespace afferent {
namespace {

Result<StepOutput> open_output(const Scene& scene, const scene::CommandFile& given, FullPipe full_pipe) {
    AFFERENT_TRY(file, CommandFile::open(scene.resolve(given.path), full_pipe));
    return StepOutput(std::move(file));
}

}  // namespace

Result<StepOutputs> StepOutputs::open(const Plan& plan, FullPipe full_pipe) {
    StepOutputs all;
    for (const scene::Output& given : plan.scene.output) {
        AFFERENT_TRY(
            output,
            std::visit([&](const auto& one) { return open_output(plan.scene, one, full_pipe); }, given));
        all.outputs_.push_back(std::move(output));
    }
    return all;
}

std::vector<std::filesystem::path> StepOutputs::unread() const {
    std::vector<std::filesystem::path> files;
    for (const StepOutput& output : outputs_)
        if (auto pipe = std::visit([](const auto& one) { return one.unread_pipe(); }, output))
            files.push_back(*std::move(pipe));
    return files;
}

std::uint64_t StepOutputs::lost_steps() const noexcept {
    std::uint64_t most = 0;
    for (const StepOutput& output : outputs_)
        most = std::max(most, std::visit([](const auto& one) { return one.lost_steps(); }, output));
    return most;
}

Result<void> StepOutputs::close() {
    Result<void> closed = success();
    for (StepOutput& output : outputs_) {
        const Result<void> one = std::visit([](auto& it) { return it.close(); }, output);
        if (closed && !one) closed = one.error();
    }
    return closed;
}

}  // namespace afferent
