// afferent replay: a recording, given to the decoder again.
#include "afferent/apps/replay_command.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <thread>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/recorder.hpp"
#include "afferent/io/wire/printable.hpp"
#include "afferent/nodes/replay.hpp"

namespace afferent {
namespace {

using Clock = std::chrono::steady_clock;

// So that Ctrl-C is seen in the longest of pauses.
constexpr auto longest_sleep = std::chrono::milliseconds(50);

class ReplayProcess {
  public:
    explicit ReplayProcess(const ReplayOptions& options)
        : options_(options),
          replay_(value_or_fail(Replay::open(
              options.file, {.events = [this](std::span<const Event> events) { recorder_->events(events); },
                             .step = [this](const ControllerStep& step) { recorder_->step(step); },
                             .anew =
                                 [this] {
                                     finish();
                                     start_recorder();
                                     paced_from_.reset();
                                 },
                             .safe =
                                 [](const std::string& reason) {
                                     std::cerr << "safe state: " << printable(reason) << '\n';
                                 }}))) {
        start_recorder();
    }

    const Scene& scene() const { return replay_->scene(); }

    void run() {
        if (options_.from_s > 0)
            value_or_fail(replay_->begin_from(scene_start + from_seconds(options_.from_s)));
        {
            Progress progress(options_.file);
            for (std::uint64_t steps = 0; !interrupted(); ++steps) {
                const auto next = value_or_fail(replay_->next());
                if (!next || !sleep_until(*next)) break;
                replay_->step();
                if (steps % 512 == 0) progress.at(replay_->fraction());
            }
        }
        finish();
        print(summarise(), options_.json);
        if (!replay_->closed()) std::cerr << options_.file << ": was not closed, and may end early\n";
        if (!options_.out.empty() && !options_.json) std::cout << "\nwritten to " << options_.out << '\n';
        if (interrupted()) throw Interrupted();
    }

  private:
    // False: interrupted.
    bool sleep_until(TimePoint time) {
        if (!options_.speed) return true;
        if (!paced_from_) paced_from_ = {Clock::now(), time};
        const auto since = std::chrono::duration_cast<Clock::duration>(Interval(time - paced_from_->scene) /
                                                                       *options_.speed);
        const auto wall = paced_from_->wall + since;
        while (!interrupted() && Clock::now() < wall)
            std::this_thread::sleep_until(std::min(wall, Clock::now() + longest_sleep));
        return !interrupted();
    }

    void start_recorder() {
        recorder_.emplace(replay_->scene(), session_folder(options_.out, ++starts_),
                          Recorder::Sides{.coprocessor = false, .hand = true});
    }

    void finish() {
        if (const auto undrawn = recorder_->finish(summarise())) std::cerr << *undrawn << '\n';
    }

    Summary summarise() const {
        const ReplayCounts counts = replay_->counts();
        Summary summary;
        summary["side"] = "replay";
        summary["scene"] = scene().description().name();
        summary["seed"] = scene().seed();
        summary["from_s"] = options_.from_s;
        summary["until_s"] = seconds(replay_->now());
        summary["closed"] = replay_->closed();
        summary["sessions"] = counts.sessions;
        summary["events"] = counts.events;
        summary["packets"] = counts.packets;
        summary["late_packets"] = counts.late;
        summary["out_of_order_packets"] = counts.out_of_order;
        summary["refused_packets"] = counts.refused;
        summary["gaps"] = counts.gaps;
        summary["lost_events"] = counts.lost_events;
        summary["freezes"] = counts.freezes;
        summary["safe_states"] = counts.safe_states;
        summary["force_error_rms_n"] = recorder_->error().rms_n();
        summary["force_error_max_n"] = recorder_->error().max_n();
        summary["run_time_s"] = Seconds(Clock::now() - began_).count();
        return summary;
    }

    struct Pace {
        Clock::time_point wall;
        TimePoint scene;
    };

    const ReplayOptions& options_;
    std::unique_ptr<Replay> replay_;
    std::optional<Recorder> recorder_;
    int starts_ = 0;
    std::optional<Pace> paced_from_;
    Clock::time_point began_ = Clock::now();
};

}  // namespace

void replay_recording(const ReplayOptions& options, const Scene* expected) {
    catch_interrupts();
    ReplayProcess process(options);
    if (expected && process.scene().fingerprint() != expected->fingerprint())
        throw Failure(options.file + ": is a recording of another scene than " + expected->name());
    process.run();
}

void add_replay_command(CLI::App& app) {
    const auto options = std::make_shared<ReplayOptions>();
    const auto fast = std::make_shared<bool>(false);
    CLI::App* command = app.add_subcommand(
        "replay", "Give a recording to the decoder again, at the wall clock's pace or another");
    command->add_option("FILE", options->file, "What run, hand or coprocessor have written with --record")
        ->required();
    CLI::Option* speed = command->add_option("--speed", options->speed, "Times the wall clock's pace")
                             ->check(CLI::Range(1e-3, 1e6));
    command->add_flag("--fast", *fast, "As fast as it goes")->excludes(speed);
    command->add_option("--from-s", options->from_s, "Begin at this time of the scene")
        ->check(CLI::Range(0.0, 1e9));
    command->add_option("--out", options->out, "Folder for force.csv, emg.csv, summary.json and the picture");
    command->add_flag("--json", options->json, "Print the summary as JSON");
    command->footer(
        "Example:\n  afferent run examples/grasp.txtpb --record grasp.afferent\n"
        "  afferent replay grasp.afferent --fast --out out/replay");
    command->callback([options, fast] {
        if (*fast) options->speed.reset();
        replay_recording(*options);
    });
}

}  // namespace afferent
