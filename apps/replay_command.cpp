// afferent replay: a recording, given to the decoder again.
#include "afferent/apps/replay_command.hpp"

#include <algorithm>
#include <iostream>
#include <memory>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/recorder.hpp"
#include "afferent/nodes/pacer.hpp"
#include "afferent/nodes/replay.hpp"
#include "afferent/nodes/run_summary.hpp"
#include "afferent/scene/fields.hpp"
#include "afferent/scene/nearest_name.hpp"

namespace afferent {
namespace {

using Clock = std::chrono::steady_clock;

using DecoderKind = decltype(scene::Decoder::kind);

// Throws Failure, with the names that there are, unless the text begins with one of them.
void check_decoder_name(const std::string& text) {
    const std::string name = text.substr(0, text.find_first_of(" \t\n{:"));
    const std::vector<std::string> names(alternative_names<DecoderKind>.begin(),
                                         alternative_names<DecoderKind>.end());
    if (std::find(names.begin(), names.end(), name) != names.end()) return;
    std::string message =
        name.empty() ? "--decoder: names no decoder" : "--decoder: there is no decoder " + name;
    if (const auto nearest = nearest_name(name, names)) message += "; did you mean " + *nearest + "?";
    message += "\ndecoders:";
    for (const std::string& each : names) message += (&each == &names.front() ? " " : ", ") + each;
    throw Failure(message);
}

// As in a scene's decoder { }; braces around nothing may be left out.
scene::Decoder decoder_of(const std::string& text) {
    check_decoder_name(text);
    const std::string fields = text.find('{') == std::string::npos ? text + " {}" : text;
    // No hand moves by what is recorded.
    const std::string accepting = " } gain { accept_unreachable_limit: true }";
    scene::Decoder named = Scene::from_text("decoder { " + fields + accepting, "--decoder").decoder;
    scene::Decoder kind_only;
    kind_only.kind = named.kind;
    if (named != kind_only)
        throw Failure(
            "--decoder: names a kind, such as \"filter\" or \"sliding_window { window_ms: 40 }\"; all "
            "else is as recorded");
    return named;
}

// As in a scene's output { }.
Scene outputs_of(const std::vector<std::string>& texts) {
    std::string scene = "gain { accept_unreachable_limit: true }";
    for (const std::string& text : texts)
        scene += " output { " + text + (text.find('{') == std::string::npos ? " {}" : "") + " }";
    return Scene::from_text(scene, "--output");
}

class ReplayCommand {
  public:
    ReplayCommand(const ReplayOptions& options, const Scene* expected) : options_(options) {
        Observer output;
        output.events = [this](std::span<const Event> events) {
            recorder_->events(events);
            if (view_) view_->events(events);
        };
        output.gap = [this](const TimeSpan& span) {
            if (view_) view_->gap(span);
        };
        output.step = [this](const ControllerStep& step) {
            recorder_->step(step);
            if (view_) view_->step(step);
        };
        output.starting_over = [this] {
            finish();
            start_recorder();
            pacer_.reset();
            if (view_) {
                view_->events_start_over();
                view_->steps_start_over();
            }
        };
        output.safe = [this](const std::string& reason) {
            std::cerr << "safe state: " << reason << '\n';
            if (view_) view_->note(replay_->now(), "safe state: " + reason);
        };
        const Scene* const outputs = expected ? expected : options.outputs ? &*options.outputs : nullptr;
        if (outputs) outputs_ = outputs->output;
        replay_ = value_or_fail(Replay::open(options.file, std::move(output), options.decoder, outputs));
        if (expected && replay_->plan().scene.fingerprint() != expected->fingerprint())
            throw Failure(options.file + ": is a recording of another scene than " + expected->file);
        start_recorder();
        view_.emplace(options.view, replay_->plan(), "replay");
    }

    void run() {
        if (!view_->wait_for_viewer()) throw Interrupted();
        if (options_.from_s > 0)
            value_or_fail(replay_->begin_from(scene_start + from_seconds(options_.from_s)));
        {
            Progress progress(options_.file);
            for (std::uint64_t steps = 0; !interrupted(); ++steps) {
                const auto next = value_or_fail(replay_->next());
                if (!next || !sleep_until(wall(*next))) break;
                replay_->step();
                view_->look_at(*replay_);
                if (steps % 512 == 0) progress.at(replay_->fraction());
            }
        }
        const Result<void> closed = replay_->close();
        print(finish(), options_.json);
        if (!replay_->closed()) std::cerr << options_.file << ": was not closed, and may end early\n";
        if (!options_.out.empty() && !options_.json) std::cout << "\nwritten to " << options_.out << '\n';
        view_->finish();
        if (!closed) throw Failure(closed.error().text);
        if (interrupted()) throw Interrupted();
    }

  private:
    Clock::time_point wall(TimePoint time) {
        if (!options_.speed) return Clock::time_point::min();
        if (!pacer_) pacer_.emplace(Clock::now(), time, *options_.speed);
        return pacer_->wall(time);
    }

    void start_recorder() {
        recorder_.emplace(replay_->plan(), session_folder(options_.out, ++starts_),
                          Recorder::Ends{.coprocessor = false, .hand = true});
    }

    Summary finish() {
        Summary summary = summary_of(*replay_, options_.from_s, recorder_->error(), outputs_);
        recorder_->add_readouts(summary);
        summary["run_time_s"] = Seconds(Clock::now() - began_).count();
        if (const auto undrawn = recorder_->finish(summary)) std::cerr << *undrawn << '\n';
        return summary;
    }

    const ReplayOptions& options_;
    std::vector<scene::Output> outputs_;
    std::unique_ptr<Replay> replay_;
    std::optional<Recorder> recorder_;
    std::optional<LiveView> view_;
    int starts_ = 0;
    std::optional<Pacer> pacer_;
    Clock::time_point began_ = Clock::now();
};

}  // namespace

void replay_recording(const ReplayOptions& options, const Scene* expected) {
    catch_interrupts();
    ReplayCommand(options, expected).run();
}

Command replay_command() {
    const auto options = std::make_shared<ReplayOptions>();
    const auto fast = std::make_shared<bool>(false);
    const auto decoder = std::make_shared<std::string>();
    const auto outputs = std::make_shared<std::vector<std::string>>();
    std::vector<Option> all{
        positional("FILE", options->file, "What run, hand or coprocessor have written with --record")
            .required(),
        option("--speed", options->speed, "Times the wall clock's pace").within(1e-3, 1e6),
        flag("--fast", *fast, "As fast as it goes").excludes("--speed"),
        option("--from-s", options->from_s, "Begin at this time of the scene").within(0, 1e9),
        option("--decoder", *decoder,
               "Another decoder on what was recorded, as in a scene: filter, or sliding_window { "
               "window_ms: "
               "40 }"),
        option("--output", *outputs,
               "An output of what is replayed, as in a scene: live_events, or command_file { path: \"c.csv\" "
               "}; those of "
               "the recorded scene stay closed. May be given several times"),
        option("--out", options->out,
               "Folder for force.csv, emg.csv, contact.csv, touches.csv, texture.csv, summary.json and the "
               "picture, as the "
               "scene asks for them"),
        flag("--json", options->json, "Print the summary as JSON"),
    };
    for (Option& each : options->view.list()) all.push_back(std::move(each));
    return {
        .name = "replay",
        .help = "Give a recording to the decoder again, at the wall clock's pace or another",
        .footer =
            "Example:\n  afferent run examples/grasp.txtpb --record grasp.afferent\n"
            "  afferent replay grasp.afferent --fast --out out/replay",
        .options = std::move(all),
        .run =
            [options, fast, decoder, outputs] {
                if (*fast) options->speed.reset();
                if (*fast && options->view.wanted())
                    throw Failure("--view: shows a replay at a pace to follow: not with --fast");
                if (!decoder->empty()) options->decoder = decoder_of(*decoder);
                if (!outputs->empty()) options->outputs = outputs_of(*outputs);
                replay_recording(*options);
            },
    };
}

}  // namespace afferent
