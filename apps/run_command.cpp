// afferent run: a whole scene in one process.
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <optional>
#include <thread>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/file_link.hpp"
#include "afferent/apps/hello.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/pacer.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/recorder.hpp"
#include "afferent/apps/scene_options.hpp"
#include "afferent/apps/side_summary.hpp"
#include "afferent/apps/standard_input.hpp"
#include "afferent/nodes/hand_recording.hpp"
#include "afferent/nodes/run.hpp"

namespace afferent {
namespace {

struct Options {
    SceneOptions scene;
    std::string out;
    std::string record;
    bool realtime = false;
    bool json = false;
};

Summary summarise(const Scene& scene, const Run& run, const Recorder& recorder,
                  const std::optional<Pacer>& pacer, TimePoint end, double run_time_s) {
    Summary summary;
    summary["scene"] = scene.description().name();
    summary["seed"] = scene.seed();
    summary["duration_s"] = seconds(end);
    summary["interrupted"] = end < scene_start + scene.duration();
    summary["samples"] = run.coprocessor().samples();
    summary["clipped_samples"] = run.source() ? run.source()->clipped() : 0;
    summary["late_scans"] = run.coprocessor().coprocessor().late_scans();
    summary["events"] = run.coprocessor().events();
    add_bus(summary, run.coprocessor().bus());
    summary["packets"] = run.packets();
    summary["link_bytes"] = run.link_bytes();
    if (const Channel* channel = run.channel()) {
        const PacketCounts received = run.received();
        summary["channel_lost"] = channel->counts().lost;
        summary["channel_dropped"] = channel->counts().dropped;
        summary["gaps"] = received.gaps;
        summary["lost_events"] = received.lost_events;
        summary["late_packets"] = received.late;
        summary["stale_packets"] = received.stale;
        summary["out_of_order_packets"] = received.out_of_order;
        summary["checksum_failures"] = run.checksum_failures();
        summary["safe_state"] = run.safe_reason();
    }
    summary["raw_sample_bytes"] = run.coprocessor().raw_sample_bytes();
    summary["force_error_rms_n"] = recorder.error().rms_n();
    summary["force_error_max_n"] = recorder.error().max_n();
    add_pace(summary, pacer);
    summary["run_time_s"] = run_time_s;
    return summary;
}

void run_scene(const Options& options) {
    catch_interrupts();
    const Scene scene = options.scene.read();
    Recorder recorder(scene, options.out, {.coprocessor = true, .hand = true});
    const auto run =
        value_or_fail(Run::open(scene,
                                {.events = [&](std::span<const Event> events) { recorder.events(events); },
                                 .step = [&](const ControllerStep& step) { recorder.step(step); }},
                                read_standard_input));
    std::optional<HandRecording> recording;
    if (const auto file = recording_file(scene, options.record)) {
        recording = value_or_fail(HandRecording::create(*file, scene, proto::RUN, run->hand()));
        recording->hello(make_hello(scene, false));
        run->record(*recording);
    }
    const auto began = Pacer::Clock::now();
    std::optional<Pacer> pacer;
    if (options.realtime) pacer.emplace(began);
    {
        Progress progress(scene.name());
        std::uint64_t steps = 0;
        while (!interrupted() && !run->done()) {
            const TimePoint due = run->next();
            if (pacer) std::this_thread::sleep_until(pacer->wall(due));
            value_or_fail(run->do_next());
            if (pacer) pacer->did(due);
            if (++steps % 512 == 0) progress.at(seconds(due) / seconds(scene.duration()));
        }
    }
    const bool broken_off = !run->done();
    const TimePoint end = broken_off ? run->next() : scene_start + scene.duration();
    run->finish(end);
    Result<void> recorded = recording ? run->close_recording() : Result<void>(success());
    const double run_time_s = Seconds(Pacer::Clock::now() - began).count();

    const Summary summary = summarise(scene, *run, recorder, pacer, end, run_time_s);
    const auto undrawn = recorder.finish(summary);
    if (undrawn) std::cerr << *undrawn << '\n';
    print(summary, options.json);
    if (!options.out.empty() && !options.json) std::cout << "\nwritten to " << options.out << '\n';
    value_or_fail(std::move(recorded));
    if (broken_off) throw Interrupted();
}

}  // namespace

void add_run_command(CLI::App& app) {
    const auto options = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand("run", "Run a scene in virtual time, or paced by the wall clock");
    options->scene.add_to(*command);
    command->add_option("--out", options->out,
                        "Folder for events.csv, force.csv, emg.csv, summary.json, grasp.svg and grasp.png");
    command->add_option("--record", options->record,
                        "File (.afferent) for what the hand receives, to replay");
    command->add_flag("--realtime", options->realtime, "Pace by the wall clock, and count missed deadlines");
    command->add_flag("--json", options->json, "Print the summary as JSON");
    command->footer("Example:\n  afferent run examples/grasp.txtpb --out out/grasp");
    command->callback([options] { run_scene(*options); });
}

}  // namespace afferent
