#include "afferent/nodes/outputs.hpp"

namespace afferent {
namespace {

Result<StepOutput> open_output(const Scene& scene, const scene::CommandFile& given) {
    AFFERENT_TRY(file, CommandFile::open(scene.resolve(given.path)));
    return StepOutput(std::move(file));
}

}  // namespace

Result<StepOutputs> StepOutputs::open(const Plan& plan) {
    StepOutputs all;
    for (const scene::Output& given : plan.scene.output) {
        AFFERENT_TRY(output,
                     std::visit([&](const auto& one) { return open_output(plan.scene, one); }, given));
        all.outputs_.push_back(std::move(output));
    }
    return all;
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
