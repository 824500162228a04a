// afferent movie: a population in motion, as a page for a browser.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/event_file.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/scene_options.hpp"
#include "afferent/apps/standard_input.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/io/files/recording.hpp"
#include "afferent/io/pictures/movie.hpp"
#include "afferent/nodes/run.hpp"
#include "afferent/scene/population.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

struct MovieOptions {
    std::string from;
    std::string out;
    double from_s = 0;
    double to_s = 0;  // 0: to the end
    double largest_mb = 32;
    std::vector<std::string> settings;
    bool json = false;
};

// A page has no more frames of pressure than this; events have their own times.
constexpr std::int64_t most_frames = 500;
constexpr Duration shortest_frame = 1ms;

// The population, its events and the pressure on the skin; what the source does not tell stays empty.
struct Shown {
    std::string title = {};
    std::string direction = "along x";
    double direction_deg = 0;
    Population population = {};
    Skin skin = {};
    TimePoint begin = scene_start;
    TimePoint end = scene_start;
    std::vector<Event> events = {};
    std::optional<PressureFrames> pressure = {};
    Duration frame = {};
};

class MovieMaker {
  public:
    explicit MovieMaker(const MovieOptions& options) : options_(options) {
        if (options.to_s > 0 && options.to_s <= options.from_s)
            throw Failure("--to-s: must be later than --from-s");
    }

    Summary make() {
        const auto file = events_file();
        if (file && !options_.settings.empty()) throw Failure("--set: goes with a scene that is run");
        if (file)
            read_events_of(*file);
        else
            run_scene(Scene::from_file(options_.from, settings_of(options_.settings)));
        if (!shown_.population.has_places())
            throw Failure(
                options_.from +
                ": no afferent has a place, so there is nothing to see from above. A patch has places "
                "where the scene gives it an outline");
        return write();
    }

  private:
    // A table or another file of events, a recording, or the events in a folder of results.
    std::optional<std::string> events_file() const {
        std::error_code ignored;
        if (fs::is_directory(options_.from, ignored))
            return (fs::path(options_.from) / "events.csv").string();
        const bool has_events = options_.from.ends_with(".afferent") || is_event_format(options_.from);
        return has_events ? std::optional(options_.from) : std::nullopt;
    }

    // The span that is asked for, of a scene or of events that end then.
    void show_until(TimePoint end) {
        shown_.begin = scene_start + from_seconds(options_.from_s);
        shown_.end = options_.to_s > 0 ? std::min(end, scene_start + from_seconds(options_.to_s)) : end;
        if (shown_.begin >= shown_.end)
            throw Failure("--from-s: the end is at " + number(seconds(end)) + " s, and nothing is later");
        if (shown_.end - shown_.begin > longest_movie)
            throw Failure("a movie has at most 70 minutes: give less of it with --from-s and --to-s");
    }

    void take_plan(const Plan& plan) {
        shown_.title = plan.scene.name;
        shown_.direction_deg = stimulus_direction_deg(plan.scene);
        if (shown_.direction_deg != 0) shown_.direction = "along the way of the stimulus";
        shown_.population = population_of(plan);
        shown_.skin = skin_of(plan);
    }

    void take_pressure(const Plan& plan) {
        shown_.frame = std::max<Duration>(shortest_frame, (shown_.end - shown_.begin) / most_frames);
        const std::int64_t frames = (shown_.end - shown_.begin) / shown_.frame + 1;
        shown_.pressure.emplace(plan.elements, shown_.begin, shown_.frame, static_cast<std::size_t>(frames));
    }

    void add(std::span<const Event> events) {
        for (const Event& event : events)
            if (event.time >= shown_.begin && event.time <= shown_.end) shown_.events.push_back(event);
        refuse_if_too_large();
    }

    static std::string number(double value) {
        std::ostringstream text;
        text << value;
        return text.str();
    }

    void refuse_if_too_large() const {
        const std::uint64_t pressed =
            shown_.pressure ? shown_.pressure->pressed() * movie_bytes_of_pressed : 0;
        const double mb =
            static_cast<double>(movie_bytes(shown_.population.afferents.size(), shown_.events.size()) +
                                pressed) *
            1e-6;
        if (mb <= options_.largest_mb) return;
        const double until_s = shown_.events.empty() ? options_.from_s : seconds(shown_.events.back().time);
        throw Failure(options_.out + ": is not written: up to " + number(until_s) + " s it takes more than " +
                      number(options_.largest_mb) +
                      " MB. Give less of it with --from-s and --to-s, or allow more with --largest-mb");
    }

    // Runs the scene up to the end of what is shown, and hears its events and scans.
    void run_plan(const Plan& plan, bool wants_events) {
        Observer output;
        output.scan = [&](const Scan& scan) { shown_.pressure->scan(scan); };
        if (wants_events) output.events = [&](std::span<const Event> events) { add(events); };
        const auto run = value_or_fail(Run::open(plan, std::move(output), read_standard_input));
        Progress progress(options_.from);
        for (std::uint64_t steps = 0; !run->done() && run->next() <= shown_.end; ++steps) {
            if (interrupted()) throw Interrupted();
            value_or_fail(run->do_next());
            if (steps % 512 == 0) {
                refuse_if_too_large();
                progress.at(seconds(run->next()) / seconds(shown_.end));
            }
        }
        run->finish(std::min(plan.end(), shown_.end + Duration(1)));
        shown_.pressure->finish(shown_.end + Duration(1));
    }

    void run_scene(const Scene& scene) {
        const Plan plan = make_plan(scene);
        take_plan(plan);
        show_until(plan.end());
        take_pressure(plan);
        run_plan(plan, true);
    }

    void read_events_of(const std::string& file) {
        EventSet set = read_event_set(file);
        shown_.population = std::move(set.population);
        const TimePoint last = set.events.empty() ? scene_start : set.events.back().time;
        std::optional<Plan> plan;
        if (file.ends_with(".afferent"))
            plan =
                make_plan(Scene::from_text(value_or_fail(RecordingReader::open(file)).head().scene(), file));
        if (plan) take_plan(*plan);
        show_until(plan ? plan->end() : last + Duration(1));
        // What pressed the skin follows from the scene, unless it came from outside.
        const bool is_repeatable = plan && plan->samples_from == SamplesFrom::coprocessor &&
                                   traits_of(plan->scene.source).clocked && shown_.population.has_places();
        if (is_repeatable) {
            take_pressure(*plan);
            run_plan(*plan, false);
        }
        add(set.events);
    }

    Summary write() {
        const PopulationRows rows(shown_.population, shown_.direction_deg);
        const std::string page = movie_page({.title = shown_.title.empty() ? options_.from : shown_.title,
                                             .direction = shown_.direction,
                                             .population = shown_.population,
                                             .skin = shown_.skin,
                                             .rows = rows,
                                             .begin = shown_.begin,
                                             .end = shown_.end,
                                             .events = shown_.events,
                                             .pressure = shown_.pressure ? &*shown_.pressure : nullptr,
                                             .pressure_interval = shown_.frame});
        refuse_if_too_large();
        // Another movie of that name stays until this one is complete.
        const fs::path part = options_.out + ".part";
        std::ofstream out(part, std::ios::binary);
        out << page;
        out.close();
        std::error_code failure;
        if (out) fs::rename(part, options_.out, failure);
        if (!out || failure) throw Failure(options_.out + ": cannot be written");
        return {{"movie", options_.out},
                {"bytes", page.size()},
                {"afferents", shown_.population.afferents.size()},
                {"events", shown_.events.size()},
                {"from_s", seconds(shown_.begin)},
                {"to_s", seconds(shown_.end)},
                {"pressure", shown_.pressure.has_value()}};
    }

    const MovieOptions& options_;
    Shown shown_;
};

void make_movie(const MovieOptions& options) {
    catch_interrupts();
    const Summary summary = MovieMaker(options).make();
    print(summary, options.json);
    if (!options.json) std::cout << "\nopen " << options.out << " in a browser\n";
}

}  // namespace

Command movie_command() {
    const auto options = std::make_shared<MovieOptions>();
    return {
        .name = "movie",
        .help = "Show a population in motion: a page for a browser, with the skin from above and its spikes",
        .footer =
            "Examples:\n  afferent movie examples/fingertip.txtpb --out fingertip.html\n"
            "  afferent movie out/fingertip --out slow.html --from-s 0.5 --to-s 0.7\n\n"
            "The page needs no network and no other file. It plays at a speed that it states, from real time "
            "to "
            "1000 times slower; fingertip.html#t=0.5 opens it at that time.",
        .options =
            {
                positional(
                    "FROM", options->from,
                    "A scene, which is run; or a recording, a folder of results, or a file of events that "
                    "tells where its afferents are")
                    .required(),
                option("--out", options->out, "The page to write, such as fingertip.html").required(),
                option("--from-s", options->from_s, "Begin at this time of the scene").within(0, 1e9),
                option("--to-s", options->to_s, "End at this time; 0: with the scene")
                    .within(0, 1e9)
                    .show_default(),
                set_option(options->settings),
                option("--largest-mb", options->largest_mb, "Write no page of more megabytes")
                    .within(0.01, 2000)
                    .show_default(),
                flag("--json", options->json, "Print what was written as JSON"),
            },
        .run = [options] { make_movie(*options); },
    };
}

}  // namespace afferent
