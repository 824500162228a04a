// Whole runs, and replays of recordings, with their results kept in memory.
#include <algorithm>
#include <cmath>
#include <optional>

#include "afferent/nodes/force_error.hpp"
#include "afferent/nodes/hello.hpp"
#include "afferent/nodes/replay.hpp"
#include "afferent/nodes/run.hpp"
#include "afferent/nodes/run_summary.hpp"
#include "afferent/python/bindings.hpp"
#include "afferent/scene/population.hpp"
#include "afferent/studies/kept_results.hpp"
#include "afferent/studies/sweep.hpp"
#include "afferent/studies/tuning_report.hpp"

namespace afferent::python {
namespace {

using Path = std::filesystem::path;

py::dtype force_dtype() {
    return row_dtype({{"time", "i8", offsetof(KeptStep, time_ns)},
                      {"true", "f8", offsetof(KeptStep, true_force_n)},
                      {"estimate", "f8", offsetof(KeptStep, estimate_n)},
                      {"sigma", "f8", offsetof(KeptStep, sigma_n)},
                      {"rate", "f8", offsetof(KeptStep, rate_hz)},
                      {"gain", "f8", offsetof(KeptStep, gain)},
                      {"doubt", "U12", offsetof(KeptStep, doubt)}},
                     sizeof(KeptStep));
}

py::dtype emg_dtype() {
    return row_dtype({{"time", "i8", offsetof(KeptStep, time_ns)},
                      {"emg", "f8", offsetof(KeptStep, closing_counts)},
                      {"closing", "f8", offsetof(KeptStep, closing_effort)},
                      {"opening", "f8", offsetof(KeptStep, opening_effort)},
                      {"command", "f8", offsetof(KeptStep, command)}},
                     sizeof(KeptStep));
}

py::dtype part_dtype() {
    return row_dtype({{"true", "f8", offsetof(KeptPart, true_force_n)},
                      {"estimate", "f8", offsetof(KeptPart, estimate_n)},
                      {"sigma", "f8", offsetof(KeptPart, sigma_n)},
                      {"doubt", "U12", offsetof(KeptPart, doubt)}},
                     sizeof(KeptPart));
}

// The rows of one kind of read-out: nothing but the columns where there are none.
template <std::size_t k>
void add_readouts(py::dict& readouts, KeptResults& kept, const py::capsule& owner) {
    using Row = std::variant_alternative_t<k, PatchReadout>;
    py::list names, formats, offsets;
    for (const KeptColumn& column : kept_columns(Row())) {
        names.append(column.name);
        formats.append(column.format);
        offsets.append(column.offset);
    }
    const std::size_t bytes = kept_row_bytes(Row());
    const py::dtype dtype(names, formats, offsets, static_cast<py::ssize_t>(bytes));
    std::vector<std::byte>& rows = kept.readouts[k];
    readouts[Row::table] = rows_in_place(dtype, rows.data(), rows.size() / bytes, bytes, owner);
    if constexpr (k + 1 < std::variant_size_v<PatchReadout>) add_readouts<k + 1>(readouts, kept, owner);
}

// Arrays over the rows, which live as long as any of them.
py::dict arrays_over(std::unique_ptr<KeptResults> kept, const Plan& plan, py::dict summary) {
    KeptResults& rows = *kept;
    const py::capsule owner = owner_of(std::move(kept));
    py::dict result;
    result["scene"] = plan.scene;
    result["events"] = rows_in_place(event_dtype(), rows.events, owner);
    result["force"] = rows_in_place(force_dtype(), rows.steps, owner);
    result["emg"] = rows_in_place(emg_dtype(), rows.steps, owner);
    py::dict readouts;
    add_readouts<0>(readouts, rows, owner);
    result["readouts"] = readouts;
    py::dict parts;
    const py::dtype of_part = part_dtype();
    const std::size_t count = plan.controller ? plan.controller->parts.size() : 0;
    for (std::size_t i = 0; i < count; ++i)
        parts[py::str(plan.controller->parts[i].name)] =
            rows_in_place(of_part, rows.parts.data() + i, rows.steps.size(), count * sizeof(KeptPart), owner);
    result["parts"] = parts;
    add_population(result, population_of(plan));
    result["resolution_ns"] = (plan.packets ? plan.packets->tick : Duration(1)).count();
    result["summary"] = std::move(summary);
    return result;
}

ForceError force_error(std::span<const KeptStep> steps) {
    ForceError error;
    for (const KeptStep& step : steps)
        if (!std::isnan(step.true_force_n)) error.add(step.estimate_n, step.true_force_n);
    return error;
}

// Entries as a dict, in their order.
py::object as_python(const Summary& summary) {
    return std::visit(
        []<class T>(const T& value) -> py::object {
            if constexpr (std::is_same_v<T, std::monostate>) {
                return py::none();
            } else if constexpr (std::is_same_v<T, Summary::List>) {
                py::list list;
                for (const Summary& each : value) list.append(as_python(each));
                return list;
            } else if constexpr (std::is_same_v<T, Summary::Entries>) {
                py::dict dict;
                for (const auto& [key, each] : value) dict[py::str(key)] = as_python(each);
                return dict;
            } else {
                return py::cast(value);
            }
        },
        summary.value());
}

py::dict as_dict(const Summary& summary, const KeptResults& kept) {
    py::dict dict = as_python(summary);
    if (!kept.doubts.seconds().empty()) dict["doubt_s"] = kept.doubts.seconds();
    return dict;
}

std::span<const double> values(const Numbers& numbers) {
    return {numbers.data(), static_cast<std::size_t>(numbers.size())};
}

// What a scan of each of these times holds: nothing, one grip force; a row; or an image.
ScanSet scans_of(const Numbers& forces, const Numbers& times_s) {
    if (forces.ndim() < 1 || forces.ndim() > 3)
        throw py::value_error(
            "forces: one grip force, a row of elements or an image for each scan, so one to "
            "three dimensions; there are " +
            std::to_string(forces.ndim()));
    if (times_s.ndim() != 1 || times_s.size() != forces.shape(0))
        throw py::value_error("times: one for each scan; there are " + std::to_string(times_s.size()) +
                              " times and " + std::to_string(forces.shape(0)) + " scans");
    const auto extent = [&](py::ssize_t axis) {
        return forces.ndim() > axis ? static_cast<std::size_t>(forces.shape(axis)) : std::size_t{1};
    };
    const bool is_image = forces.ndim() == 3;
    auto scans = ScanSet::of(values(times_s), is_image ? extent(1) : 1, is_image ? extent(2) : extent(1),
                             is_image, values(forces));
    if (!scans) throw py::value_error("forces: " + scans.error().text);
    return std::move(scans).value();
}

EmgTable emg_of(const Numbers& counts, const Numbers& times_s) {
    if (counts.ndim() != 1 || times_s.ndim() != 1 || counts.size() != times_s.size() || counts.size() == 0)
        throw py::value_error("emg: one value of the closing electrode for each time, so one dimension");
    EmgTable table;
    for (py::ssize_t i = 0; i < counts.size(); ++i) {
        const double time_s = times_s.at(i);
        if (!(time_s >= 0 && time_s <= 1e9) || !std::isfinite(counts.at(i)))
            throw py::value_error("emg: sample " + std::to_string(i) +
                                  " is not a number at a time from 0 on");
        table.times.push_back(scene_start + from_seconds(time_s));
        if (i > 0 && table.times[static_cast<std::size_t>(i)] <= table.times[static_cast<std::size_t>(i) - 1])
            throw py::value_error("emg: times must rise; that of sample " + std::to_string(i) + " does not");
        table.counts.push_back(counts.at(i));
    }
    return table;
}

struct Samples {
    std::optional<Numbers> forces;
    std::optional<Numbers> force_times_s;
    bool in_counts = false;
    std::optional<Numbers> emg;
    std::optional<Numbers> emg_times_s;
};

// The scene with tables in the places of the given arrays.
Scene scene_for(Scene scene, const Samples& samples, const std::optional<double>& duration_s) {
    if (samples.forces) {
        if (traits_of(scene.source).from == SamplesFrom::hand || !force_table(scene.source))
            scene.source = scene::Table();
        scene::Table& table = *force_table(scene.source);
        table.path = "forces";
        table.column = {samples.in_counts ? "forces_counts" : "forces_n"};
    }
    if (samples.emg) {
        if (!scene.hand.emg_table) scene.hand.emg_table.emplace();
        scene.hand.emg_table->path = "emg";
    }
    if (duration_s) scene.duration_s = *duration_s;
    return scene;
}

// The file of the recording: that of a link that is one, or that of the caller; nothing if there is none.
std::optional<Path> recording_file(const Plan& plan, const std::optional<Path>& record) {
    const std::optional<Path> of_link = link_file(plan.scene);
    if (of_link && record) throw py::value_error("record: the scene's link is a recording already");
    if (of_link) return of_link;
    if (record && plan.in_process())
        throw py::value_error(
            "record: a recording is of packets, and this scene's link is in process, without any. Give the "
            "scene a link, as in link=\"tcp\"");
    return record;
}

py::dict run(const Scene& given, const Samples& samples, const std::optional<double>& duration_s,
             const py::object& progress, const std::optional<Path>& record) {
    GivenTables tables;
    if (samples.forces) tables.forces = scans_of(*samples.forces, samples.force_times_s.value());
    if (samples.emg) tables.emg = emg_of(*samples.emg, samples.emg_times_s.value());
    const Scene scene = scene_for(given, samples, duration_s);
    auto kept = std::make_unique<KeptResults>();
    std::optional<Plan> plan;
    std::unique_ptr<Run> run;
    Watch watch(progress);
    double run_time_s = 0;
    {
        const py::gil_scoped_release unlocked;
        plan.emplace(make_plan(scene));
        if (plan->controller) {
            // A longer run, which may be broken off, takes memory as it goes.
            const double steps = std::min(1e6, seconds(plan->end()) * scene.hand.emg_rate_hz);
            kept->expect_steps(static_cast<std::size_t>(steps) + 1, plan->controller->parts.size());
        }
        run = value_or_throw(Run::open(*plan,
                                       {.events = [&](std::span<const Event> events) { kept->add(events); },
                                        .step = [&](const ControllerStep& step) { kept->add(step); }},
                                       {}, nullptr, std::move(tables)));
        if (const auto file = recording_file(*plan, record))
            value_or_throw(run->record(*file, make_hello(*plan, false)));
        const auto began = std::chrono::steady_clock::now();
        try {
            for (std::uint64_t i = 1; !run->done(); ++i) {
                value_or_throw(run->do_next());
                if (i % 64 == 0) watch.at(seconds(run->next()) / seconds(plan->end()));
            }
        } catch (...) {
            // A recording is complete up to here.
            run->finish(run->next());
            (void)run->close();
            throw;
        }
        run->finish(plan->end());
        value_or_throw(run->close());
        run_time_s = Seconds(std::chrono::steady_clock::now() - began).count();
    }
    watch.done();
    py::dict summary = as_dict(summary_of(*run, plan->end(), force_error(kept->steps), std::nullopt), *kept);
    summary["run_time_s"] = run_time_s;
    return arrays_over(std::move(kept), *plan, std::move(summary));
}

py::dict read_recording(const Path& file, const std::optional<Scene>& decoding, const py::object& progress) {
    auto kept = std::make_unique<KeptResults>();
    std::string safe_reason;
    std::unique_ptr<Replay> replay;
    Watch watch(progress);
    {
        const py::gil_scoped_release unlocked;
        Observer output{.events = [&](std::span<const Event> events) { kept->add(events); },
                        .step = [&](const ControllerStep& step) { kept->add(step); },
                        .safe = [&](const std::string& reason) { safe_reason = reason; }};
        replay = value_or_throw(Replay::open(file, std::move(output),
                                             decoding ? std::optional(decoding->decoder) : std::nullopt));
        for (std::uint64_t i = 1;; ++i) {
            const auto next = value_or_throw(replay->next());
            if (!next) break;
            replay->step();
            if (i % 64 == 0) watch.at(replay->fraction());
        }
    }
    watch.done();
    py::dict summary = as_dict(summary_of(*replay, 0, force_error(kept->steps), {}), *kept);
    summary["duration_s"] = seconds(replay->now());
    summary["safe_state"] = safe_reason;
    return arrays_over(std::move(kept), replay->plan(), std::move(summary));
}

struct PointRow {
    double duration_s;
    std::uint64_t events;
    std::uint64_t packets;
    std::uint64_t link_bytes;
    std::uint64_t raw_sample_bytes;
    double force_error_rms_n;
    double force_error_max_n;
    double within_two_sigmas;
    double lowest_gain;
    double run_time_s;
};

PointRow row_of(const SweepPoint& point) {
    const double unknown = std::nan("");
    const RunFigures figures = point.figures.value_or(RunFigures{.duration_s = unknown,
                                                                 .force_error_rms_n = {},
                                                                 .force_error_max_n = {},
                                                                 .within_two_sigmas = {},
                                                                 .lowest_gain = {},
                                                                 .run_time_s = unknown});
    return {figures.duration_s,
            figures.events,
            figures.packets,
            figures.link_bytes,
            figures.raw_sample_bytes,
            figures.force_error_rms_n.value_or(unknown),
            figures.force_error_max_n.value_or(unknown),
            figures.within_two_sigmas.value_or(unknown),
            figures.lowest_gain.value_or(unknown),
            figures.run_time_s};
}

// The rows, and why each was refused.
py::tuple sweep_over(const Scene& scene,
                     const std::vector<std::pair<std::string, std::vector<std::string>>>& over,
                     std::size_t threads, const py::object& progress) {
    std::vector<SweepAxis> axes;
    for (const auto& [path, values] : over) axes.push_back({path, values});
    Watch watch(progress);
    std::vector<SweepPoint> points;
    {
        const py::gil_scoped_release unlocked;
        std::exception_ptr thrown;
        const auto go_on = [&](double fraction) {
            try {
                watch.at(fraction);
            } catch (...) {
                thrown = std::current_exception();
            }
            return !thrown;
        };
        points = sweep(scene, axes, {.threads = threads, .progress = go_on});
        if (thrown) std::rethrow_exception(thrown);
    }
    watch.done();
    auto rows = std::make_unique<std::vector<PointRow>>();
    std::vector<std::string> refusals;
    for (const SweepPoint& point : points) {
        rows->push_back(row_of(point));
        refusals.push_back(point.refusal);
    }
    const py::dtype dtype = row_dtype({{"duration_s", "f8", offsetof(PointRow, duration_s)},
                                       {"events", "u8", offsetof(PointRow, events)},
                                       {"packets", "u8", offsetof(PointRow, packets)},
                                       {"link_bytes", "u8", offsetof(PointRow, link_bytes)},
                                       {"raw_sample_bytes", "u8", offsetof(PointRow, raw_sample_bytes)},
                                       {"force_error_rms_n", "f8", offsetof(PointRow, force_error_rms_n)},
                                       {"force_error_max_n", "f8", offsetof(PointRow, force_error_max_n)},
                                       {"within_two_sigmas", "f8", offsetof(PointRow, within_two_sigmas)},
                                       {"lowest_gain", "f8", offsetof(PointRow, lowest_gain)},
                                       {"run_time_s", "f8", offsetof(PointRow, run_time_s)}},
                                      sizeof(PointRow));
    auto& placed = *rows;
    return py::make_tuple(rows_in_place(dtype, placed, owner_of(std::move(rows))), refusals);
}

}  // namespace

void bind_run(py::module_& module) {
    module.def(
        "run",
        [](const Scene& scene, std::optional<Numbers> forces, std::optional<Numbers> force_times_s,
           bool in_counts, std::optional<Numbers> emg, std::optional<Numbers> emg_times_s,
           std::optional<double> duration_s, const py::object& progress, const std::optional<Path>& record) {
            return run(scene,
                       {std::move(forces), std::move(force_times_s), in_counts, std::move(emg),
                        std::move(emg_times_s)},
                       duration_s, progress, record);
        },
        py::arg("scene"), py::arg("forces"), py::arg("force_times_s"), py::arg("in_counts"), py::arg("emg"),
        py::arg("emg_times_s"), py::arg("duration_s"), py::arg("progress"), py::arg("record"));
    module.def("sweep", sweep_over, py::arg("scene"), py::arg("over"), py::arg("threads"),
               py::arg("progress"));
    module.def(
        "tuning",
        [](const Scene& scene, std::uint32_t address, double radius_mm, double hold_mm,
           std::optional<double> samples_hz) {
            std::optional<AfferentTuning> tuning;
            {
                const py::gil_scoped_release unlocked;
                tuning = value_or_throw(tuning_of(
                    make_plan(scene), address,
                    {.radius_mm = radius_mm, .hold_mm = hold_mm, .rate_hz = samples_hz, .progress = {}}));
            }
            return as_python(summary_of(*tuning));
        },
        py::arg("scene"), py::arg("address"), py::arg("radius_mm"), py::arg("hold_mm"),
        py::arg("samples_hz"));
    module.def(
        "tunings",
        [](const Scene& scene, const std::string& patch, double radius_mm, double hold_mm,
           std::optional<double> samples_hz) {
            std::vector<AfferentTuning> tunings;
            {
                const py::gil_scoped_release unlocked;
                tunings = value_or_throw(tuning_of_patch(
                    make_plan(scene), patch,
                    {.radius_mm = radius_mm, .hold_mm = hold_mm, .rate_hz = samples_hz, .progress = {}}));
            }
            return py::object(as_python(summary_of(tunings))["afferents"]);
        },
        py::arg("scene"), py::arg("patch"), py::arg("radius_mm"), py::arg("hold_mm"), py::arg("samples_hz"));
    module.def("read_recording", read_recording, py::arg("file"), py::arg("decoding"), py::arg("progress"));
}

}  // namespace afferent::python
