// afferent sweep: a scene with every combination of some of its fields' values, in one table.
#include <algorithm>
#include <iomanip>
#include <iostream>
#include <memory>
#include <sstream>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/results.hpp"
#include "afferent/apps/scene_options.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/io/files/table_writer.hpp"
#include "afferent/io/pictures/scatter_picture.hpp"
#include "afferent/studies/sweep.hpp"

namespace afferent {
namespace {

struct SweepCommandOptions {
    SceneOptions scene;
    std::vector<std::string> over;
    std::uint64_t threads = 0;
    std::string out;
    bool json = false;
};

// A row of the table, by column; without what is not known.
Summary row_of(const SweepPoint& point) {
    Summary row;
    for (const Setting& setting : point.settings) row[setting.path] = setting.value;
    if (const auto& figures = point.figures) {
        row["events"] = figures->events;
        row["packets"] = figures->packets;
        row["link_bytes"] = figures->link_bytes;
        row["raw_sample_bytes"] = figures->raw_sample_bytes;
        row["force_error_rms_n"] = or_null(figures->force_error_rms_n);
        row["force_error_max_n"] = or_null(figures->force_error_max_n);
        row["within_two_sigmas"] = or_null(figures->within_two_sigmas);
        row["lowest_gain"] = or_null(figures->lowest_gain);
        row["run_time_s"] = figures->run_time_s;
    }
    if (!point.refusal.empty()) row["refusal"] = point.refusal;
    return row;
}

std::vector<std::string> columns_of(std::span<const SweepAxis> axes) {
    std::vector<std::string> columns;
    for (const SweepAxis& axis : axes) columns.push_back(axis.path);
    for (const char* figure : {"events", "packets", "link_bytes", "raw_sample_bytes", "force_error_rms_n",
                               "force_error_max_n", "within_two_sigmas", "lowest_gain", "run_time_s"})
        columns.push_back(figure);
    return columns;
}

std::string cell_text(const Summary* value) {
    if (!value) return "";
    if (const std::string* text = value->text()) return *text;
    const auto number = value->number();
    if (!number) return "";
    std::ostringstream text;
    text << std::setprecision(std::holds_alternative<double>(value->value()) ? 4 : 15) << *number;
    return text.str();
}

void print_table(const std::vector<std::string>& columns, const Summary::List& rows) {
    std::vector<std::vector<std::string>> cells{columns};
    for (const Summary& row : rows) {
        cells.emplace_back();
        for (const std::string& column : columns) cells.back().push_back(cell_text(row.find(column)));
    }
    std::vector<std::size_t> widths(columns.size());
    for (const auto& line : cells)
        for (std::size_t i = 0; i < line.size(); ++i) widths[i] = std::max(widths[i], line[i].size());
    for (const auto& line : cells) {
        for (std::size_t i = 0; i < line.size(); ++i)
            std::cout << (i ? "  " : "") << std::setw(static_cast<int>(widths[i])) << line[i];
        std::cout << '\n';
    }
    for (const Summary& row : rows)
        if (const Summary* refusal = row.find("refusal"))
            std::cout << "not run: " << *refusal->text() << '\n';
}

void write_table(const std::vector<std::string>& columns, const Summary::List& rows,
                 const std::filesystem::path& file) {
    const std::vector<std::string_view> names(columns.begin(), columns.end());
    TableWriter table(file, names);
    for (const Summary& row : rows) {
        for (const std::string& column : columns) {
            const Summary* value = row.find(column);
            const auto number = value ? value->number() : std::nullopt;
            if (value && value->text())
                table.text(*value->text());
            else if (!number)
                table.no_value();
            else if (std::holds_alternative<double>(value->value()))
                table.cell(*number);
            else
                table.cell(static_cast<std::uint64_t>(*number));
        }
        table.end_row();
    }
    if (const auto error = table.close()) throw Failure(error->message());
}

// What a byte buys, or an event where there are no packets: a line for each value of the first axis.
ScatterPicture picture_of(const Scene& scene, std::span<const SweepAxis> axes,
                          std::span<const SweepPoint> points) {
    const bool has_packets = std::ranges::any_of(
        points, [](const SweepPoint& point) { return point.figures && point.figures->link_bytes > 0; });
    ScatterPicture picture{.title = scene.file,
                           .x_title = has_packets ? "bytes on the link per second" : "events per second",
                           .y_title = "RMS error of the force (N)",
                           .series = {}};
    constexpr std::size_t most_series = 12;
    const bool one_series = axes.front().values.size() > most_series;
    for (const SweepPoint& point : points) {
        if (!point.figures || !point.figures->force_error_rms_n) continue;
        const std::string name = one_series ? axes.front().path : point.settings.front().text();
        auto series = std::ranges::find(picture.series, name, &ScatterPicture::Series::name);
        if (series == picture.series.end())
            series = picture.series.insert(series, {.name = name, .points = {}});
        const auto amount = has_packets ? point.figures->link_bytes : point.figures->events;
        series->points.push_back(
            {static_cast<double>(amount) / point.figures->duration_s, *point.figures->force_error_rms_n});
    }
    return picture;
}

void sweep_scene(const SweepCommandOptions& options) {
    catch_interrupts();
    if (options.over.empty())
        throw Failure("sweep: --over PATH=VALUE,VALUE is missing: what is it to sweep over?");
    const Scene scene = options.scene.read();
    std::vector<SweepAxis> axes;
    for (const std::string& each : options.over) axes.push_back(SweepAxis::from(each));
    const auto columns = columns_of(axes);
    Results results(options.out, {"sweep.csv", "sweep.svg", "sweep.png", "sweep.json"});

    Progress progress("sweep of " + scene.file);
    const auto points = sweep(scene, axes, {.threads = options.threads, .progress = [&](double fraction) {
                                                progress.at(fraction);
                                                return !interrupted();
                                            }});
    Summary::List rows;
    for (const SweepPoint& point : points)
        if (point.figures || !point.refusal.empty()) rows.push_back(row_of(point));
    Summary summary{{"scene", scene.name}, {"interrupted", interrupted()}, {"points", rows}};
    if (results.wanted()) {
        write_table(columns, rows, results.file("sweep.csv"));
        const ScatterPicture picture = picture_of(scene, axes, points);
        if (!picture.series.empty()) tell_if_undrawn(draw(picture, results.file("sweep")));
        results.put_in_place(summary, "sweep.json");
    }
    if (options.json)
        print(summary, true);
    else
        print_table(columns, rows);
    if (interrupted()) throw Interrupted();
}

}  // namespace

Command sweep_command() {
    const auto options = std::make_shared<SweepCommandOptions>();
    return {
        .name = "sweep",
        .help = "Run a scene with every combination of some of its fields' values, over the cores",
        .footer =
            "Prints a row for each combination. The same figures for any number of threads, but for "
            "run_time_s,\nwhich is measured beside the other runs.\n"
            "Examples:\n"
            "  afferent sweep examples/lossy.txtpb --over decoder=sliding_window,inversion,filter\n"
            "  afferent sweep examples/grasp.txtpb --set link=udp --over link.packet_ms=1,5,20 \\\n"
            "    --over neuron.delta_g=0,0.1,0.3 --out out/sweep",
        .options = options->scene.followed_by({
            option("--over", options->over,
                   "A field and the values that it takes: PATH=VALUE,VALUE,..., with paths and values as for "
                   "--set. Given several times: every combination, the last fastest"),
            option("--threads", options->threads, "Runs at a time; 0: as many as the machine has"),
            option("--out", options->out,
                   "Folder for sweep.csv, sweep.json, and sweep.svg and .png: error against bytes"),
            flag("--json", options->json, "Print the table as JSON"),
        }),
        .run = [options] { sweep_scene(*options); },
    };
}

}  // namespace afferent
