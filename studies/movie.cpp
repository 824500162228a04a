#include "afferent/studies/movie.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <sstream>
#include <utility>

#include "afferent/io/files/event_files.hpp"
#include "afferent/io/files/hdf5_format.hpp"
#include "afferent/io/files/recording.hpp"
#include "afferent/io/pictures/movie.hpp"
#include "afferent/nodes/event_file.hpp"
#include "afferent/nodes/observer.hpp"
#include "afferent/scene/population.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

// A page has no more frames of pressure than this; events have their own times.
constexpr std::int64_t most_frames = 500;
constexpr Duration shortest_frame = 1ms;
constexpr std::uint64_t steps_between_looks = 512;

Error not_allowed(std::string text) { return {Error::Kind::not_allowed, std::move(text)}; }

std::string number(double value) {
    std::ostringstream text;
    text << value;
    return text.str();
}

// A table or another file of events, a recording, or the events in a folder of results.
std::optional<std::string> events_file(const std::string& from) {
    std::error_code ignored;
    if (fs::is_directory(from, ignored)) return (fs::path(from) / "events.csv").string();
    const bool has_events = from.ends_with(".afferent") || hdf5_format_of(from) || format_of(from);
    return has_events ? std::optional(from) : std::nullopt;
}

// Collects the population, its events and the pressure on the skin; what the source does not tell stays
// empty.
class MovieMaker {
  public:
    MovieMaker(const std::string& from, const MovieOptions& options) : from_(from), options_(options) {}

    Result<void> run_scene(const Scene& scene) {
        const Plan plan = make_plan(scene);
        take_plan(plan);
        AFFERENT_TRY(show_until(plan.end()));
        take_pressure(plan);
        return run_plan(plan, true);
    }

    Result<void> read_events_of(const std::string& file) {
        AFFERENT_TRY(read, read_event_file(file));
        made_.remarks = std::move(read.remarks);
        population_ = std::move(read.set.population);
        const std::vector<Event>& events = read.set.events;
        std::optional<Plan> plan;
        if (file.ends_with(".afferent")) {
            AFFERENT_TRY(recording, RecordingReader::open(file));
            plan = make_plan(Scene::from_text(recording.head().scene(), file));
        }
        if (plan) take_plan(*plan);
        const TimePoint last = events.empty() ? scene_start : events.back().time;
        AFFERENT_TRY(show_until(plan ? plan->end() : last + Duration(1)));
        // What pressed the skin follows from the scene, unless it came from outside.
        const bool is_repeatable = plan && plan->samples_from == SamplesFrom::coprocessor &&
                                   traits_of(plan->scene.source).clocked && population_.has_positions();
        if (is_repeatable) {
            take_pressure(*plan);
            AFFERENT_TRY(run_plan(*plan, false));
        }
        add(events);
        return success();
    }

    Result<MovieOfPopulation> finish() && {
        if (made_.is_stopped) return std::move(made_);
        if (!population_.has_positions())
            return not_allowed(
                from_ +
                ": no afferent has a place, so there is nothing to see from above. A patch has "
                "places where the scene gives it an outline");
        AFFERENT_TRY(refuse_if_too_large());
        const PopulationRows rows(population_, direction_deg_);
        made_.page =
            movie_page({.title = title_.empty() ? from_ : title_,
                        .direction = direction_deg_ != 0 ? "along the way of the stimulus" : "along x",
                        .population = population_,
                        .skin = skin_,
                        .rows = rows,
                        .begin = made_.begin,
                        .end = made_.end,
                        .events = events_,
                        .pressure = pressure_ ? &*pressure_ : nullptr,
                        .pressure_interval = frame_});
        made_.afferents = population_.afferents.size();
        made_.events = events_.size();
        made_.has_pressure = pressure_.has_value();
        return std::move(made_);
    }

  private:
    // The span that is asked for, of a scene or of events that end then.
    Result<void> show_until(TimePoint end) {
        made_.begin = scene_start + from_seconds(options_.from_s);
        made_.end = options_.to_s > 0 ? std::min(end, scene_start + from_seconds(options_.to_s)) : end;
        if (made_.begin >= made_.end)
            return not_allowed("--from-s: the end is at " + number(seconds(end)) +
                               " s, and nothing is later");
        if (made_.end - made_.begin > longest_movie)
            return not_allowed("a movie has at most 70 minutes: give less of it with --from-s and --to-s");
        return success();
    }

    void take_plan(const Plan& plan) {
        title_ = plan.scene.name;
        direction_deg_ = stimulus_direction_deg(plan.scene);
        population_ = population_of(plan);
        skin_ = skin_of(plan);
    }

    void take_pressure(const Plan& plan) {
        frame_ = std::max<Duration>(shortest_frame, (made_.end - made_.begin) / most_frames);
        const std::int64_t frames = (made_.end - made_.begin) / frame_ + 1;
        pressure_.emplace(plan.elements, made_.begin, frame_, static_cast<std::size_t>(frames));
    }

    void add(std::span<const Event> events) {
        for (const Event& event : events)
            if (event.time >= made_.begin && event.time <= made_.end) events_.push_back(event);
    }

    Result<void> refuse_if_too_large() const {
        const std::uint64_t pressed = pressure_ ? pressure_->pressed() * movie_bytes_of_pressed : 0;
        const double mb =
            static_cast<double>(movie_bytes(population_.afferents.size(), events_.size()) + pressed) * 1e-6;
        if (mb <= options_.largest_mb) return success();
        const double until_s = events_.empty() ? options_.from_s : seconds(events_.back().time);
        return not_allowed("up to " + number(until_s) + " s the movie takes more than " +
                           number(options_.largest_mb) +
                           " MB. Give less of it with --from-s and --to-s, or allow more with --largest-mb");
    }

    // Runs the scene up to the end of what is shown, and takes its events and scans.
    Result<void> run_plan(const Plan& plan, bool wants_events) {
        Observer observer;
        observer.scan = [&](const Scan& scan) { pressure_->scan(scan); };
        if (wants_events) observer.events = [&](std::span<const Event> events) { add(events); };
        AFFERENT_TRY(run, Run::open(plan, std::move(observer), options_.standard_input));
        for (std::uint64_t steps = 0; !run->done() && run->next() <= made_.end; ++steps) {
            AFFERENT_TRY(run->do_next());
            if (steps % steps_between_looks != 0) continue;
            AFFERENT_TRY(refuse_if_too_large());
            made_.is_stopped =
                options_.progress && !options_.progress(seconds(run->next()) / seconds(made_.end));
            if (made_.is_stopped) return success();
        }
        run->finish(std::min(plan.end(), made_.end + Duration(1)));
        pressure_->finish(made_.end + Duration(1));
        return success();
    }

    const std::string& from_;
    const MovieOptions& options_;
    std::string title_;
    double direction_deg_ = 0;
    Population population_;
    Skin skin_;
    std::vector<Event> events_;
    std::optional<PressureFrames> pressure_;
    Duration frame_{};
    MovieOfPopulation made_;
};

}  // namespace

Result<MovieOfPopulation> movie_of(const std::string& from, const MovieOptions& options) {
    if (options.to_s > 0 && options.to_s <= options.from_s)
        return not_allowed("--to-s: must be later than --from-s");
    MovieMaker maker(from, options);
    const auto file = events_file(from);
    if (file && !options.settings.empty()) return not_allowed("--set: goes with a scene that is run");
    if (file) {
        AFFERENT_TRY(maker.read_events_of(*file));
    } else {
        AFFERENT_TRY(maker.run_scene(Scene::from_file(from, options.settings)));
    }
    return std::move(maker).finish();
}

}  // namespace afferent
