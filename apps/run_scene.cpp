#include "afferent/apps/run_scene.hpp"

#include <chrono>
#include <iostream>
#include <optional>

#include "afferent/apps/failure.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/recorder.hpp"
#include "afferent/apps/recording_file.hpp"
#include "afferent/apps/standard_input.hpp"
#include "afferent/nodes/hello.hpp"
#include "afferent/nodes/pacer.hpp"
#include "afferent/nodes/run.hpp"
#include "afferent/nodes/run_summary.hpp"

namespace afferent {
namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

std::vector<Option> RunOptions::followed_by(std::vector<Option> others) {
    std::vector<Option> views = view.list();
    std::vector<Option> all = scene.followed_by({
        option("--out", out,
               "Folder for events.csv, force.csv, emg.csv, summary.json, grasp.svg and grasp.png; where "
               "afferents have places, afferents.csv, population.svg and population.png; where the scene "
               "asks for them, contact.csv, touches.csv and texture.csv, and readouts.svg and readouts.png"),
        option("--record", record, "File (.afferent) for what the hand receives, to replay"),
        flag("--realtime", realtime, "Pace by the wall clock, and count missed deadlines"),
        flag("--json", json, "Print the summary as JSON"),
    });
    for (auto* more : {&others, &views}) std::move(more->begin(), more->end(), std::back_inserter(all));
    return all;
}

void run_scene(const RunOptions& options, const Plan& plan, EventExchange* exchange,
               const std::function<void(Summary&)>& add_to) {
    if (options.view.wanted() && !options.realtime)
        throw Failure("--view: shows a run as it happens, at the wall clock's pace: add --realtime");
    Recorder recorder(plan, options.out, {.coprocessor = true, .hand = true});
    LiveView view(options.view, plan, "run");
    const auto run = value_or_fail(Run::open(plan,
                                             {.events =
                                                  [&](std::span<const Event> events) {
                                                      recorder.events(events);
                                                      view.events(events);
                                                  },
                                              .step =
                                                  [&](const ControllerStep& step) {
                                                      recorder.step(step);
                                                      view.step(step);
                                                  },
                                              .scan = [&](const Scan& scan) { recorder.scan(scan); }},
                                             read_standard_input, exchange));
    if (const auto file = recording_file(plan, options.record))
        value_or_fail(run->record(*file, make_hello(plan, false)));
    if (!view.wait_for_viewer()) throw Interrupted();
    const auto began = Clock::now();
    std::optional<Pacer> pacer;
    if (options.realtime) pacer.emplace(began);
    {
        Progress progress(plan.scene.file);
        std::uint64_t steps = 0;
        while (!interrupted() && !recorder.failed() && !run->done()) {
            const TimePoint due = run->next();
            if (pacer && !sleep_until(pacer->wall(due))) break;
            value_or_fail(run->do_next(pacer ? pacer->lag(due, Clock::now()) : Duration::zero()));
            if (pacer) pacer->did(due, Clock::now());
            view.look_at(*run, due, pacer);
            if (++steps % 512 == 0) progress.at(seconds(due) / seconds(plan.end()));
        }
    }
    const bool broken_off = !run->done();
    const TimePoint end = broken_off ? run->next() : plan.end();
    run->finish(end);
    if (broken_off) recorder.broken_off(end);
    Result<void> recorded = run->close();

    Summary summary = summary_of(*run, end, recorder.error(), pacer);
    recorder.add_readouts(summary);
    summary["run_time_s"] = Seconds(Clock::now() - began).count();
    if (add_to) add_to(summary);
    const auto undrawn = recorder.finish(summary);
    if (undrawn) std::cerr << *undrawn << '\n';
    print(summary, options.json);
    if (!options.out.empty() && !options.json) std::cout << "\nwritten to " << options.out << '\n';
    view.finish();
    value_or_fail(std::move(recorded));
    if (broken_off || (options.view.is_the_purpose && interrupted())) throw Interrupted();
}

}  // namespace afferent
