#include "afferent/apps/recorder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "afferent/apps/failure.hpp"
#include "afferent/io/files/afferent_table.hpp"
#include "afferent/scene/population.hpp"

namespace afferent {
namespace {

// A picture cannot show more: of more spikes it shows how densely they lie.
constexpr std::size_t most_events_drawn = 300'000;
constexpr std::uint64_t most_steps_drawn = 10'000;
constexpr std::size_t most_parts_drawn = 32;

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

}  // namespace

std::filesystem::path session_folder(const std::filesystem::path& out, int n) {
    return out.empty() || n == 1 ? out : out / ("session-" + std::to_string(n));
}

Recorder::Recorder(const Plan& plan, const std::filesystem::path& folder, Ends link_ends, FullPipe full_pipe)
    : plan_(plan),
      repeatable_(link_ends.coprocessor && link_ends.hand),
      readouts_(plan),
      readout_picture_(plan),
      end_(plan.end()) {
    if (plan.controller && link_ends.hand) part_errors_.resize(plan.controller->parts.size());
    const Scene& scene = plan.scene;
    const scene::Record& record = scene.record;
    draws_ = !folder.empty() && record.picture && link_ends.hand;
    if (folder.empty()) return;
    if (record.picture) view_.emplace(plan);
    if (view_ && !view_->has_positions()) view_.reset();
    std::vector<std::string> names;
    if (link_ends.coprocessor) names.insert(names.end(), {"events.csv", "afferents.csv"});
    if (link_ends.hand)
        names.insert(names.end(),
                     {"force.csv", "emg.csv", "grasp.svg", "grasp.png", "readouts.svg", "readouts.png"});
    if (link_ends.hand)
        for (std::string& name : ReadoutTables::names()) names.push_back(std::move(name));
    names.insert(names.end(), {"population.svg", "population.png"});
    names.push_back("summary.json");
    results_.emplace(value_or_fail(ResultsFolder::create(folder, std::move(names))));
    const std::filesystem::path& unfinished = results_->unfinished();
    if (record.events && link_ends.coprocessor)
        events_.emplace(unfinished / "events.csv",
                        std::initializer_list<std::string_view>{"time_s", "address"}, full_pipe);
    if (const Population population = population_of(plan); events_ && population.has_positions())
        if (const auto error = write_afferents(unfinished / "afferents.csv", population, Duration(1)))
            throw Failure(error->message());
    if (record.force && link_ends.hand) {
        std::vector<std::string> columns{"time_s",  "true_force_n", "estimate_n", "sigma_n",
                                         "rate_hz", "gain",         "doubt"};
        if (plan.controller)
            for (const PartPlan& part : plan.controller->parts)
                for (const char* what : {"_true_n", "_estimate_n", "_sigma_n", "_doubt"})
                    columns.push_back(part.name + what);
        force_.emplace(unfinished / "force.csv",
                       std::vector<std::string_view>(columns.begin(), columns.end()), full_pipe);
        emg_.emplace(
            unfinished / "emg.csv",
            std::initializer_list<std::string_view>{"time_s", "emg", "closing", "opening", "command"},
            full_pipe);
    }
    if (link_ends.hand) readouts_.open(unfinished, full_pipe);
    for (const auto* writer : tables())
        if (*writer && (*writer)->error()) throw Failure((*writer)->error()->message());
    // The picture shows the parts only if there are few.
    if (draws_ && part_errors_.size() <= most_parts_drawn)
        for (std::size_t i = 0; i < part_errors_.size(); ++i) {
            const PartPlan& part = plan.controller->parts[i];
            picture_.parts.push_back({part.name, part.patch, {}, {}});
        }
    const double steps = seconds(plan.end()) * scene.hand.emg_rate_hz;
    step_stride_ = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(steps) / most_steps_drawn);
}

std::vector<std::optional<TableWriter>*> Recorder::tables() {
    std::vector<std::optional<TableWriter>*> all{&events_, &force_, &emg_};
    const auto readouts = readouts_.writers();
    all.insert(all.end(), readouts.begin(), readouts.end());
    return all;
}

void Recorder::events(std::span<const Event> events) {
    if (events_) {
        for (const Event& event : events) {
            events_->cell(event.time);
            events_->cell(std::uint64_t{event.address});
            events_->end_row();
        }
    }
    if (view_) view_->events(events);
    if (!draws_) return;
    if (!picture_.density && picture_.events.size() + events.size() > most_events_drawn) {
        picture_.density.emplace(0, seconds(plan_.end()), plan_.addresses);
        picture_.density->add(picture_.events);
        picture_.events = {};
    }
    if (picture_.density)
        picture_.density->add(events);
    else
        picture_.events.insert(picture_.events.end(), events.begin(), events.end());
}

void Recorder::write_if_known(std::optional<double> force_n) {
    if (force_n)
        force_->cell(*force_n);
    else
        force_->no_value();
}

void Recorder::add_readouts(Summary& summary) const {
    for (const auto& [doubt, doubted_s] : doubts_.seconds()) summary["doubt_s"][doubt] = doubted_s;
    for (std::size_t i = 0; i < part_errors_.size(); ++i)
        summary["part_force_error_rms_n"][plan_.controller->parts[i].name] = or_null(part_errors_[i].rms_n());
    readouts_.add_to(summary);
}

void Recorder::step(const ControllerStep& step) {
    if (step.true_force_n) error_.add(step.estimate.force_n, *step.true_force_n);
    for (std::size_t i = 0; i < step.parts.size(); ++i)
        if (const auto& true_n = step.parts[i].true_force_n)
            part_errors_[i].add(step.parts[i].estimate.force_n, *true_n);
    doubts_.add(step.estimate.doubt, step.time);
    readouts_.step(step);
    if (force_) {
        force_->cell(step.time);
        write_if_known(step.true_force_n);
        force_->cell(step.estimate.force_n);
        force_->cell(step.estimate.sigma_n);
        force_->cell(step.estimate.rate_hz);
        force_->cell(step.gain);
        force_->text(name(step.estimate.doubt));
        for (const auto& [estimate, true_force_n] : step.parts) {
            write_if_known(true_force_n);
            force_->cell(estimate.force_n);
            force_->cell(estimate.sigma_n);
            force_->text(name(estimate.doubt));
        }
        force_->end_row();
        emg_->cell(step.time);
        emg_->cell(step.closing_counts);
        emg_->cell(step.effort.closing);
        emg_->cell(step.effort.opening);
        emg_->cell(step.command);
        emg_->end_row();
        if (force_->error() || emg_->error()) ++unwritten_steps_;
    }
    if (!draws_) return;
    readout_picture_.step(step);
    if (steps_++ % step_stride_ == 0) keep_for_picture(step);
}

bool Recorder::failed() const noexcept {
    return (events_ && events_->error()) || (force_ && force_->error()) || (emg_ && emg_->error()) ||
           readouts_.failed();
}

void Recorder::keep_for_picture(const ControllerStep& step) {
    picture_.time_s.push_back(seconds(step.time));
    picture_.true_force_n.push_back(step.true_force_n.value_or(unknown));
    picture_.estimate_n.push_back(step.estimate.force_n);
    picture_.sigma_n.push_back(step.estimate.sigma_n);
    picture_.rate_hz.push_back(step.estimate.rate_hz);
    picture_.gain.push_back(step.gain);
    picture_.emg.push_back(step.effort.closing);
    picture_.command.push_back(step.command);
    for (std::size_t i = 0; i < picture_.parts.size(); ++i) {
        picture_.parts[i].true_force_n.push_back(step.parts[i].true_force_n.value_or(unknown));
        picture_.parts[i].estimate_n.push_back(step.parts[i].estimate.force_n);
    }
}

std::uint64_t Recorder::unwritten_steps() const noexcept {
    return unwritten_steps_ + (force_ ? std::max(force_->lost_rows(), emg_->lost_rows()) : 0);
}

void Recorder::close_tables() {
    if (std::exchange(tables_are_closed_, true)) return;
    std::optional<TableError> first;
    for (auto* writer : tables())
        if (*writer)
            if (const auto error = (*writer)->close()) {
                auto& kept = (*writer)->is_pipe() ? pipe_error_ : first;
                if (!kept) kept = error;
            }
    if (first) throw Failure(first->message() + kept_unfinished());
}

void Recorder::close(const Summary& summary) {
    close_tables();
    if (!results_) return;
    try {
        write(summary, results_->unfinished() / "summary.json");
        value_or_fail(results_->put_in_place());
    } catch (const Failure& failure) {
        throw Failure(failure.what() + kept_unfinished());
    }
    // The failed pipe has not affected the other tables.
    if (pipe_error_) throw Failure(pipe_error_->message());
}

std::string Recorder::kept_unfinished() {
    if (!results_ || repeatable_) return "";
    results_->keep_unfinished();
    return "\nwhat there is of it stays in " + results_->unfinished().string();
}

std::optional<std::string> Recorder::put_in_place(const Drawing& drawing, const std::string& stem) {
    for (const char* ending : {".svg", ".png"}) value_or_fail(results_->add(stem + ending));
    switch (drawing.outcome) {
        case Drawn::done:
            return std::nullopt;
        case Drawn::no_gnuplot:
            return "no picture: gnuplot is not installed";
        case Drawn::failed:
            return "no picture: gnuplot failed: " + drawing.message;
    }
    return std::nullopt;
}

std::optional<std::string> Recorder::draw_pictures() {
    std::optional<std::string> undrawn;
    if (view_) {
        undrawn = put_in_place(view_->draw(end_, results_->unfinished() / "population"), "population");
    }
    if (!draws_ || picture_.time_s.empty()) return undrawn;
    if (!readout_picture_.is_empty()) {
        const auto reason =
            put_in_place(readout_picture_.draw(results_->unfinished() / "readouts"), "readouts");
        if (!undrawn) undrawn = reason;
    }
    picture_.begin_s = 0;
    picture_.end_s = picture_.time_s.back();
    picture_.levels = {{"gain 0 from here", plan_.scene.gain.limit_n}};
    for (const PatchPlan& patch : plan_.patches)
        picture_.patches.push_back({patch.name, patch.first, patch.afferents(), !patch.sustained()});
    const auto grasp = put_in_place(draw(picture_, results_->unfinished() / "grasp"), "grasp");
    return undrawn ? undrawn : grasp;
}

}  // namespace afferent
