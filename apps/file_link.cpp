#include "afferent/apps/file_link.hpp"

#include <algorithm>

#include "afferent/apps/failure.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/recorder.hpp"
#include "afferent/apps/recording_file.hpp"
#include "afferent/apps/replay_command.hpp"
#include "afferent/apps/standard_input.hpp"
#include "afferent/nodes/coprocessor_end.hpp"
#include "afferent/nodes/hand_recording.hpp"
#include "afferent/nodes/hello.hpp"
#include "afferent/nodes/pacer.hpp"
#include "afferent/nodes/run_summary.hpp"

namespace afferent {
namespace {

Summary summarise(const Scene& scene, const CoprocessorEnd& link_end, const std::optional<Pacer>& pacer,
                  TimePoint end) {
    Summary summary;
    add_progress(summary, "coprocessor", scene, end);
    add_coprocessor(summary, link_end);
    add_pace(summary, pacer);
    return summary;
}

// Runs until the scene's end, or until Ctrl-C; returns the time that was reached.
TimePoint step_through(const Plan& plan, CoprocessorEnd& link_end, const Observer& output,
                       std::optional<Pacer>& pacer) {
    const TimePoint end = plan.end();
    Progress progress(plan.scene.file);
    for (std::uint64_t steps = 0;; ++steps) {
        const TimePoint due = link_end.next().time;
        if (pacer) sleep_until(pacer->wall(std::min(due, end)));
        if (interrupted()) return std::min(due, end);
        if (due > end) return end;
        value_or_fail(link_end.do_next(output));
        if (pacer) pacer->did(due, std::chrono::steady_clock::now());
        if (steps % 512 == 0) progress.at(seconds(due) / seconds(plan.end()));
    }
}

}  // namespace

bool send_to_file(const EndOptions& options) {
    const Plan plan = make_plan(options.scene.read());
    if (!link_file(plan.scene)) return false;
    if (plan.samples_from == SamplesFrom::hand)
        throw Failure(plan.scene.file + ": the samples are the hand's, and a file does not ask it for them");
    if (std::holds_alternative<scene::Chip>(plan.scene.source))
        throw Failure(plan.scene.file +
                      ": source.chip has a line in real time: give the scene a link to a hand");
    if (options.view.wanted())
        throw Failure("--view: the scene's link is a file; record it, then show it with afferent view FILE");
    const auto file = recording_file(plan, options.record);
    Recorder recorder(plan, options.out, {.coprocessor = true, .hand = false});
    const auto link_end = value_or_fail(CoprocessorEnd::open(plan, read_standard_input));
    HandRecording recording = value_or_fail(HandRecording::create(*file, plan, proto::COPROCESSOR, nullptr));
    recording.hello(make_hello(plan, options.lockstep));
    recording.begin(scene_start, true);

    Observer output;
    output.events = [&](std::span<const Event> events) { recorder.events(events); };
    output.scan = [&](const Scan& scan) { recorder.scan(scan); };
    output.packet = [&](const proto::Envelope& packet) { recording.packet(packet); };
    std::optional<Pacer> pacer;
    if (!options.lockstep) pacer.emplace(std::chrono::steady_clock::now());
    const TimePoint end = step_through(plan, *link_end, output, pacer);
    link_end->finish(end, output);
    if (interrupted()) recorder.broken_off(end);
    proto::Bye bye;
    bye.set_reason(interrupted() ? proto::INTERRUPTED : proto::END_OF_SCENE);
    bye.set_time_ns((end - scene_start).count());
    bye.set_packets(link_end->packetizer()->packets());
    bye.set_events(link_end->packetizer()->events());
    recording.bye(bye);
    Result<void> recorded = recording.close(end);

    const Summary summary = summarise(plan.scene, *link_end, pacer, end);
    recorder.finish(summary);
    print(summary, options.json);
    value_or_fail(std::move(recorded));
    if (interrupted()) throw Interrupted();
    return true;
}

bool receive_from_file(const EndOptions& options) {
    const Scene scene = options.scene.read();
    const auto file = link_file(scene);
    if (!file) return false;
    if (!options.record.empty()) throw Failure("--record: the scene's link is a recording already");
    ReplayOptions replay{
        .file = file->string(), .out = options.out, .json = options.json, .view = options.view};
    if (options.lockstep) replay.speed.reset();
    replay_recording(replay, &scene);
    return true;
}

}  // namespace afferent
