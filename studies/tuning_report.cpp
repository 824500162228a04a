#include "afferent/studies/tuning_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <limits>
#include <numeric>
#include <sstream>

#include "afferent/io/files/table_writer.hpp"

namespace afferent {
namespace {

// An odd number, so that equal intervals are in the middle of one.
constexpr int bins = 41;

struct Intervals {
    double mean_ms = 0;
    double variation = 0;  // coefficient of
};

std::optional<Intervals> intervals_of(const AfferentTuning& tuning) {
    const auto& all = tuning.intervals_ms;
    if (all.empty()) return std::nullopt;
    const auto count = static_cast<double>(all.size());
    const double mean_ms = std::accumulate(all.begin(), all.end(), 0.0) / count;
    double squares = 0;
    for (const double each : all) squares += (each - mean_ms) * (each - mean_ms);
    return Intervals{mean_ms, std::sqrt(squares / count) / mean_ms};
}

Summary number(const std::optional<double>& value) { return value ? Summary(*value) : Summary(); }

std::string text(const std::optional<double>& value) {
    if (!value) return "-";
    std::ostringstream out;
    out << std::setprecision(3) << *value;
    return out.str();
}

std::string name_of(const AfferentTuning& tuning) {
    std::ostringstream out;
    out << tuning.kind << ", address " << tuning.address << " of patch " << tuning.patch << " at "
        << std::setprecision(4) << tuning.place.x_mm << ", " << tuning.place.y_mm << " mm; probe of "
        << tuning.radius_mm << " mm radius, " << tuning.rate_hz << " samples a second";
    return out.str();
}

double decibels(const std::optional<double>& um) {
    return um ? 20 * std::log10(*um) : std::numeric_limits<double>::quiet_NaN();
}

PanelGrid::Panel field_panel(const AfferentTuning& tuning) {
    PanelGrid::Curve x{.name = "along x", .x = {}, .y = {}};
    PanelGrid::Curve y{.name = "along y", .x = {}, .y = {}};
    for (const auto& each : tuning.field) {
        x.x.push_back(each.offset_mm), x.y.push_back(each.along_x);
        y.x.push_back(each.offset_mm), y.y.push_back(each.along_y);
    }
    return {.title = "Field: " + text(tuning.field_mm2) + " mm² at " + text(tuning.field_depth_um) + " µm",
            .x_title = "Distance of the probe (mm)",
            .y_title = "Spikes in 0.1 s",
            .curves = {std::move(x), std::move(y)}};
}

PanelGrid::Panel frequency_panel(const AfferentTuning& tuning) {
    PanelGrid::Curve threshold{.name = "threshold", .x = {}, .y = {}, .marked = true};
    PanelGrid::Curve once{.name = "once a cycle", .x = {}, .y = {}, .marked = true};
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const auto& each : tuning.frequencies)
        for (auto* const curve : {&threshold, &once}) {
            const double db = decibels(curve == &once ? each.once_a_cycle_um : each.threshold_um);
            curve->x.push_back(each.hz), curve->y.push_back(db);
            if (std::isfinite(db)) low = std::min(low, db), high = std::max(high, db);
        }
    PanelGrid::Panel panel{.title = "Tuning curve",
                           .x_title = "Frequency (Hz)",
                           .y_title = "Amplitude (dB re 1 µm)",
                           .curves = {std::move(threshold), std::move(once)},
                           .logarithmic_x = true};
    if (low <= high) panel.y_range = {low - 5, high + 5};
    return panel;
}

PanelGrid::Panel depth_panel(const AfferentTuning& tuning) {
    PanelGrid::Curve onset{.name = "first 0.1 s", .x = {}, .y = {}, .marked = true};
    PanelGrid::Curve held{.name = "0.5 to 1 s", .x = {}, .y = {}, .marked = true};
    for (const auto& each : tuning.depths) {
        onset.x.push_back(each.depth_mm), onset.y.push_back(each.onset_hz);
        held.x.push_back(each.depth_mm), held.y.push_back(each.held_hz);
    }
    return {.title = "Rate against depth",
            .x_title = "Depth (mm)",
            .y_title = "Rate (Hz)",
            .curves = {std::move(onset), std::move(held)}};
}

PanelGrid::Panel interval_panel(const AfferentTuning& tuning) {
    const auto intervals = intervals_of(tuning);
    std::string title = "Intervals held at " + text(tuning.hold_mm) + " mm: ";
    title += intervals ? "variation " + text(intervals->variation) : "none";
    // From 0 to twice the mean, where the longest fits in.
    const double longest_ms =
        intervals ? std::max(2 * intervals->mean_ms, *std::ranges::max_element(tuning.intervals_ms)) : 1;
    std::vector<double> counts(bins + 1);
    for (const double each : tuning.intervals_ms)
        ++counts[std::min<std::size_t>(bins - 1, static_cast<std::size_t>(bins * each / longest_ms))];
    PanelGrid::Curve curve{.name = "intervals", .x = {}, .y = {}};
    for (int i = 0; i < bins; ++i)
        for (const int edge : {i, i + 1}) {
            curve.x.push_back(longest_ms * edge / bins);
            curve.y.push_back(counts[static_cast<std::size_t>(i)]);
        }
    return {.title = std::move(title),
            .x_title = "Interval (ms)",
            .y_title = "Number",
            .curves = {std::move(curve)}};
}

// What a map shows of an afferent; none where it is not found.
struct Property {
    const char* column;
    const char* title;
    bool logarithmic;
    std::optional<double> (*of)(const AfferentTuning&);
};

// The frequency with the lowest threshold, the first of several.
const AfferentTuning::Frequency* best(const AfferentTuning& tuning) {
    const auto um = [](const AfferentTuning::Frequency& each) {
        return each.threshold_um.value_or(std::numeric_limits<double>::infinity());
    };
    const auto found = std::ranges::min_element(tuning.frequencies, {}, um);
    return found != tuning.frequencies.end() && found->threshold_um ? &*found : nullptr;
}

using Found = std::optional<double>;
constexpr std::array<Property, 6> properties{{
    {"threshold_um", "Threshold of an indentation (µm)", true,
     [](const AfferentTuning& tuning) { return tuning.threshold_um; }},
    {"field_mm2", "Field at 4.5 thresholds (mm²)", false,
     [](const AfferentTuning& tuning) { return tuning.threshold_um ? Found(tuning.field_mm2) : Found(); }},
    {"held_hz", "Rate of the hold (Hz)", false,
     [](const AfferentTuning& tuning) {
         const auto intervals = intervals_of(tuning);
         return Found(intervals ? 1000 / intervals->mean_ms : 0);
     }},
    {"best_hz", "Best frequency (Hz)", true,
     [](const AfferentTuning& tuning) { return best(tuning) ? Found(best(tuning)->hz) : Found(); }},
    {"best_threshold_um", "Threshold there (µm)", true,
     [](const AfferentTuning& tuning) { return best(tuning) ? best(tuning)->threshold_um : Found(); }},
    {"interval_variation", "Variation of intervals held", false,
     [](const AfferentTuning& tuning) {
         const auto intervals = intervals_of(tuning);
         return intervals ? Found(intervals->variation) : Found();
     }},
}};

std::string name_of(const std::vector<AfferentTuning>& patch) {
    std::ostringstream out;
    out << "Patch " << patch.front().patch << ", " << patch.size() << " afferents of kind "
        << patch.front().kind << "; probe of " << patch.front().radius_mm << " mm radius, held at "
        << patch.front().hold_mm << " mm, " << patch.front().rate_hz << " samples a second";
    return out.str();
}

}  // namespace

Summary summary_of(const std::vector<AfferentTuning>& patch) {
    Summary summary;
    for (const AfferentTuning& tuning : patch) summary["afferents"].push_back(summary_of(tuning));
    return summary;
}

void print(const std::vector<AfferentTuning>& patch, std::ostream& out) {
    out << name_of(patch) << "\n\n"
        << std::left << std::setw(20) << "" << std::right << std::setw(8) << "found" << std::setw(12)
        << "quarter" << std::setw(12) << "median" << std::setw(12) << "quarter" << '\n';
    for (const Property& property : properties) {
        std::vector<double> all;
        for (const AfferentTuning& tuning : patch)
            if (const auto value = property.of(tuning)) all.push_back(*value);
        std::ranges::sort(all);
        out << std::left << std::setw(20) << property.column << std::right << std::setw(8) << all.size();
        for (const double share : {0.25, 0.5, 0.75})
            out << std::setw(12)
                << text(all.empty() ? Found()
                                    : Found(all[static_cast<std::size_t>(
                                          std::lround(share * static_cast<double>(all.size() - 1)))]));
        out << '\n';
    }
}

Result<void> write_map(const std::vector<AfferentTuning>& patch, const std::filesystem::path& file) {
    std::vector<std::string_view> columns{"address", "x_mm", "y_mm"};
    for (const Property& property : properties) columns.push_back(property.column);
    TableWriter table(file, columns);
    for (const AfferentTuning& tuning : patch) {
        table.cell(std::uint64_t{tuning.address});
        table.cell(tuning.place.x_mm);
        table.cell(tuning.place.y_mm);
        for (const Property& property : properties)
            if (const auto value = property.of(tuning))
                table.cell(*value);
            else
                table.no_value();
        table.end_row();
    }
    if (const auto error = table.close()) return Error{Error::Kind::unreachable, error->message()};
    return success();
}

SkinMaps tuning_maps(const std::vector<AfferentTuning>& patch) {
    SkinMaps picture{.title = name_of(patch), .places = {}, .maps = {}};
    for (const AfferentTuning& tuning : patch) picture.places.push_back(tuning.place);
    for (const Property& property : properties) {
        SkinMaps::Map map{property.title, {}, property.logarithmic};
        for (const AfferentTuning& tuning : patch)
            map.values.push_back(property.of(tuning).value_or(std::numeric_limits<double>::quiet_NaN()));
        picture.maps.push_back(std::move(map));
    }
    return picture;
}

Summary summary_of(const AfferentTuning& tuning) {
    Summary summary{{"address", tuning.address},
                    {"patch", tuning.patch},
                    {"kind", tuning.kind},
                    {"x_mm", tuning.place.x_mm},
                    {"y_mm", tuning.place.y_mm},
                    {"samples_hz", tuning.rate_hz},
                    {"probe_radius_mm", tuning.radius_mm},
                    {"threshold_um", number(tuning.threshold_um)},
                    {"field_depth_um", tuning.field_depth_um},
                    {"field_mm2", tuning.field_mm2}};
    for (const auto& each : tuning.field)
        summary["field"].push_back({{"offset_mm", each.offset_mm},
                                    {"spikes_along_x", each.along_x},
                                    {"spikes_along_y", each.along_y}});
    for (const auto& each : tuning.frequencies)
        summary["frequencies"].push_back({{"frequency_hz", each.hz},
                                          {"threshold_um", number(each.threshold_um)},
                                          {"once_a_cycle_um", number(each.once_a_cycle_um)}});
    for (const auto& each : tuning.depths)
        summary["depths"].push_back(
            {{"depth_mm", each.depth_mm}, {"onset_hz", each.onset_hz}, {"held_hz", each.held_hz}});
    summary["hold_mm"] = tuning.hold_mm;
    const auto intervals = intervals_of(tuning);
    summary["mean_interval_ms"] = intervals ? Summary(intervals->mean_ms) : Summary();
    summary["interval_variation"] = intervals ? Summary(intervals->variation) : Summary();
    for (const double each : tuning.intervals_ms) summary["intervals_ms"].push_back(each);
    return summary;
}

void print(const AfferentTuning& tuning, std::ostream& out) {
    out << name_of(tuning) << "\n\n";
    if (tuning.threshold_um)
        out << "It fires from an indentation of " << text(tuning.threshold_um) << " µm on, and at "
            << text(tuning.field_depth_um) << " µm on " << text(tuning.field_mm2) << " mm² of skin.\n\n";
    else
        out << "No indentation makes it fire.\n\n";
    out << std::right << std::setw(14) << "frequency_hz" << std::setw(14) << "threshold_um" << std::setw(17)
        << "once_a_cycle_um" << '\n';
    for (const auto& each : tuning.frequencies)
        out << std::setw(14) << each.hz << std::setw(14) << text(each.threshold_um) << std::setw(17)
            << text(each.once_a_cycle_um) << '\n';
    out << '\n'
        << std::setw(14) << "depth_mm" << std::setw(14) << "onset_hz" << std::setw(17) << "held_hz" << '\n';
    for (const auto& each : tuning.depths)
        out << std::setw(14) << each.depth_mm << std::setw(14) << each.onset_hz << std::setw(17)
            << each.held_hz << '\n';
    const auto intervals = intervals_of(tuning);
    out << "\nHeld at " << text(tuning.hold_mm) << " mm, from half a second on, it ";
    if (intervals)
        out << "fires every " << text(intervals->mean_ms) << " ms, with a coefficient of variation of "
            << text(intervals->variation) << ".\n";
    else
        out << "fires no longer.\n";
}

PanelGrid tuning_picture(const AfferentTuning& tuning) {
    PanelGrid grid{.title = name_of(tuning), .columns = 2, .panels = {}};
    if (!tuning.field.empty()) grid.panels.push_back(field_panel(tuning));
    if (!tuning.frequencies.empty()) grid.panels.push_back(frequency_panel(tuning));
    grid.panels.push_back(depth_panel(tuning));
    if (!tuning.intervals_ms.empty()) grid.panels.push_back(interval_panel(tuning));
    return grid;
}

}  // namespace afferent
