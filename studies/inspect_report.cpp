#include "afferent/studies/inspect_report.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <iomanip>
#include <string>

namespace afferent {
namespace {

constexpr std::size_t most_panels = 12;
constexpr std::size_t most_points_drawn_of_column = 1000;

const char* use_name(ColumnInspection::Use use) {
    constexpr std::array names{"grip force", "force", "EMG", "not used"};
    return names[static_cast<std::size_t>(use)];
}

// Lowest and highest value of each stretch, so that nothing short is left out.
PanelGrid::Curve curve_of(const Table& table, std::size_t column) {
    PanelGrid::Curve curve{.name = "", .x = {}, .y = {}};
    const std::size_t stretch = std::max<std::size_t>(1, 2 * table.rows() / most_points_drawn_of_column);
    for (std::size_t begin = 0; begin < table.rows(); begin += stretch) {
        std::size_t low = begin;
        std::size_t high = begin;
        for (std::size_t i = begin; i < std::min(begin + stretch, table.rows()); ++i) {
            if (table.row(i)[column] < table.row(low)[column]) low = i;
            if (table.row(i)[column] > table.row(high)[column]) high = i;
        }
        for (const std::size_t i : {std::min(low, high), std::max(low, high)}) {
            curve.x.push_back(seconds(table.times[i]));
            curve.y.push_back(table.row(i)[column]);
            if (low == high) break;
        }
    }
    return curve;
}

}  // namespace

Summary summary_of(const TableInspection& found) {
    Summary summary{{"table", found.table.file}, {"rows", found.table.rows()}};
    summary["rate_hz"] = found.rate_hz;
    summary["length_s"] = seconds(found.length);
    summary["shortest_interval_ms"] = Milliseconds(found.shortest_interval).count();
    summary["longest_interval_ms"] = Milliseconds(found.longest_interval).count();
    summary["gaps"] = found.gaps;
    summary["longest_gaps"] = Summary::List{};
    for (const TableInspection::Gap& gap : found.longest_gaps)
        summary["longest_gaps"].push_back(
            {{"begin_s", seconds(gap.begin)}, {"length_ms", Milliseconds(gap.length).count()}});
    summary["columns"] = Summary::List{};
    for (const ColumnInspection& column : found.columns)
        summary["columns"].push_back({{"name", column.name},
                                      {"taken_for", use_name(column.use)},
                                      {"unit", column.unit.empty() ? Summary() : Summary(column.unit)},
                                      {"reason", column.reason},
                                      {"lowest", column.lowest},
                                      {"median", column.median},
                                      {"highest", column.highest}});
    summary["taken_for"] = Summary::List{};
    for (const std::string& sentence : found.sentences) summary["taken_for"].push_back(sentence);
    summary["assumed"] = Summary::List{};
    for (const std::string& sentence : found.assumptions) summary["assumed"].push_back(sentence);
    summary["scene"] = found.scene ? Summary(found.scene->text(Scene::TextLayout::field_a_line)) : Summary();
    if (!found.scene) summary["why_no_scene"] = found.why_no_scene;
    return summary;
}

void print(const TableInspection& found, std::ostream& out) {
    out << found.table.file << "\n\n";
    for (const std::string& sentence : found.sentences) out << "  " << sentence << '\n';
    out << "\n  " << found.table.rows() << " rows, " << std::setprecision(6) << seconds(found.length) << " s";
    if (found.rate_hz > 0)
        out << ", " << found.rate_hz << " a second (intervals of "
            << Milliseconds(found.shortest_interval).count() << " to "
            << Milliseconds(found.longest_interval).count() << " ms), "
            << (found.gaps == 0 ? "no" : std::to_string(found.gaps)) << (found.gaps == 1 ? " gap" : " gaps");
    out << '\n';
    for (const TableInspection::Gap& gap : found.longest_gaps)
        out << "    a gap of " << Milliseconds(gap.length).count() << " ms at " << seconds(gap.begin)
            << " s\n";
    std::size_t width = 6;
    for (const ColumnInspection& column : found.columns) width = std::max(width, column.name.size());
    const int name_width = static_cast<int>(std::min<std::size_t>(width, 32)) + 2;
    out << "\n  " << std::left << std::setw(name_width) << "column" << std::setw(12) << "taken for"
        << std::setw(10) << "in" << std::right << std::setw(13) << "lowest" << std::setw(13) << "median"
        << std::setw(13) << "highest"
        << "  because\n";
    for (const ColumnInspection& column : found.columns)
        out << "  " << std::left << std::setw(name_width) << column.name << std::setw(12)
            << use_name(column.use) << std::setw(10) << (column.unit.empty() ? "-" : column.unit)
            << std::right << std::setprecision(5) << std::setw(13) << column.lowest << std::setw(13)
            << column.median << std::setw(13) << column.highest << "  " << column.reason << '\n';
    out << '\n';
    for (const std::string& sentence : found.assumptions) out << "  Assumed: " << sentence << "\n\n";
}

PanelGrid picture_of(const TableInspection& found) {
    const std::size_t panels = std::min(found.columns.size(), most_panels);
    PanelGrid picture{
        .title = std::filesystem::path(found.table.file).filename().string() +
                 (panels < found.columns.size() ? ": the first " + std::to_string(panels) + " of " +
                                                      std::to_string(found.columns.size()) + " columns"
                                                : ""),
        .columns = panels > 3 ? std::size_t{2} : std::size_t{1},
        .panels = {}};
    for (std::size_t i = 0; i < panels; ++i) {
        const ColumnInspection& column = found.columns[i];
        picture.panels.push_back({.title = column.name + " (" + use_name(column.use) + ")",
                                  .x_title = i + picture.columns >= panels ? "Time (s)" : "",
                                  .y_title = column.unit,
                                  .curves = {curve_of(found.table, i)}});
    }
    return picture;
}

}  // namespace afferent
