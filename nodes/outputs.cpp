#include "afferent/nodes/outputs.hpp"

#include <algorithm>

namespace afferent {
namespace {

// The output that the scene describes by such a struct.
template <class Described, class Outputs>
struct OutputOf;
template <class Described, class O, class... Others>
struct OutputOf<Described, std::variant<O, Others...>>
    : std::conditional_t<std::is_same_v<typename O::Described, Described>, std::type_identity<O>,
                         OutputOf<Described, std::variant<Others...>>> {};
template <class Described>
using OutputFor = typename OutputOf<Described, AnyOutput>::type;

OutputThread thread_of(const scene::Output& given) {
    return std::visit([]<class Described>(const Described&) { return OutputFor<Described>::thread; }, given);
}

Result<AnyOutput> open_output(const Scene& scene, const scene::Output& given, FullPipe full_pipe) {
    return std::visit(
        [&]<class Described>(const Described& described) -> Result<AnyOutput> {
            AFFERENT_TRY(opened, OutputFor<Described>::open(scene, described, full_pipe));
            return AnyOutput(std::move(opened));
        },
        given);
}

}  // namespace

Result<Outputs> Outputs::open(const Scene& scene, std::optional<OutputThread> thread, FullPipe full_pipe) {
    Outputs all;
    for (const scene::Output& given : scene.output) {
        if (thread && thread_of(given) != *thread) continue;
        AFFERENT_TRY(output, open_output(scene, given, full_pipe));
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
