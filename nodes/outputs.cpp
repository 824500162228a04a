#include "afferent/nodes/outputs.hpp"

#include <algorithm>

namespace afferent {
namespace {

template <class O>
Result<AnyOutput> as_any(Result<O> opened) {
    if (!opened) return opened.error();
    return AnyOutput(std::move(opened).value());
}

Result<AnyOutput> open_output(const Scene& scene, const scene::CommandFile& given, FullPipe full_pipe) {
    return as_any(CommandFile::open(scene.resolve(given.path), full_pipe));
}

Result<AnyOutput> open_output(const Scene& scene, const scene::LiveEvents& given, FullPipe) {
    return as_any(LiveEvents::open(scene, given));
}

OutputThread thread_of(const scene::CommandFile&) { return CommandFile::thread; }
OutputThread thread_of(const scene::LiveEvents&) { return LiveEvents::thread; }

}  // namespace

Result<Outputs> Outputs::open(const Scene& scene, std::optional<OutputThread> thread, FullPipe full_pipe) {
    Outputs all;
    for (const scene::Output& given : scene.output) {
        if (thread && std::visit([](const auto& one) { return thread_of(one); }, given) != *thread) continue;
        AFFERENT_TRY(output,
                     std::visit([&](const auto& one) { return open_output(scene, one, full_pipe); }, given));
        all.outputs_.push_back(std::move(output));
    }
    return all;
}

std::vector<std::string> Outputs::notices() const {
    std::vector<std::string> all;
    for (const AnyOutput& output : outputs_)
        if (auto notice = std::visit([](const auto& one) { return one.notice(); }, output))
            all.push_back(*std::move(notice));
    return all;
}

OutputLosses Outputs::lost() const noexcept {
    OutputLosses most;
    for (const AnyOutput& output : outputs_) {
        const OutputLosses lost = std::visit([](const auto& one) { return one.lost(); }, output);
        most.steps = std::max(most.steps, lost.steps);
        most.events = std::max(most.events, lost.events);
    }
    return most;
}

Result<void> Outputs::close() {
    Result<void> closed = success();
    for (AnyOutput& output : outputs_) {
        const Result<void> one = std::visit([](auto& it) { return it.close(); }, output);
        if (closed && !one) closed = one.error();
    }
    return closed;
}

}  // namespace afferent
