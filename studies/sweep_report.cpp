#include "afferent/studies/sweep_report.hpp"

#include <algorithm>
#include <iomanip>
#include <sstream>
#include <string_view>

#include "afferent/io/files/table_writer.hpp"

namespace afferent {
namespace {

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

}  // namespace

SweepTable::SweepTable(std::span<const SweepAxis> axes, std::span<const SweepPoint> points)
    : columns_(columns_of(axes)) {
    for (const SweepPoint& point : points)
        if (point.figures || !point.refusal.empty()) rows_.push_back(row_of(point));
}

void SweepTable::print(std::ostream& out) const {
    std::vector<std::vector<std::string>> cells{columns_};
    for (const Summary& row : rows_) {
        cells.emplace_back();
        for (const std::string& column : columns_) cells.back().push_back(cell_text(row.find(column)));
    }
    std::vector<std::size_t> widths(columns_.size());
    for (const auto& line : cells)
        for (std::size_t i = 0; i < line.size(); ++i) widths[i] = std::max(widths[i], line[i].size());
    for (const auto& line : cells) {
        for (std::size_t i = 0; i < line.size(); ++i)
            out << (i ? "  " : "") << std::setw(static_cast<int>(widths[i])) << line[i];
        out << '\n';
    }
    for (const Summary& row : rows_)
        if (const Summary* refusal = row.find("refusal")) out << "not run: " << *refusal->text() << '\n';
}

Result<void> SweepTable::write(const std::filesystem::path& file) const {
    const std::vector<std::string_view> names(columns_.begin(), columns_.end());
    TableWriter table(file, names);
    for (const Summary& row : rows_) {
        for (const std::string& column : columns_) {
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
    if (const auto error = table.close()) return Error{Error::Kind::unreachable, error->message()};
    return success();
}

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

}  // namespace afferent
