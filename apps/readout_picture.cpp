#include "afferent/apps/readout_picture.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "afferent/runtime/overloaded.hpp"

namespace afferent {
namespace {

constexpr std::size_t most_points = 10'000;
// More are too many dots.
constexpr std::size_t most_marked = 200;
constexpr double untold = std::numeric_limits<double>::quiet_NaN();

// "force_n" of "force_sigma_n"; empty of anything else.
std::string column_of_sigma(const std::string& name) {
    constexpr std::string_view sigma = "_sigma";
    const std::size_t at = name.find(sigma);
    return at == std::string::npos ? "" : name.substr(0, at) + name.substr(at + sigma.size());
}

// After so many degrees an angle of this column is the same again; 0 if it is no angle.
double turn_of(const std::string& name) {
    return name == "direction_deg" ? 360 : name == "orientation_deg" ? 180 : 0;
}

void keep_every_second(std::vector<double>& values) {
    for (std::size_t i = 0; 2 * i < values.size(); ++i) values[i] = values[2 * i];
    values.resize((values.size() + 1) / 2);
}

}  // namespace

void ReadoutPicture::Curve::keep(double time_s, const std::vector<std::pair<std::string, double>>& numbers) {
    times_s.push_back(time_s);
    for (const auto& [name, number] : numbers) {
        const std::string of = column_of_sigma(name);
        (of.empty() ? columns[name].values : columns[of].sigmas).push_back(number);
    }
    if (times_s.size() < most_points) return;
    every *= 2;
    keep_every_second(times_s);
    for (auto& [name, column] : columns) {
        keep_every_second(column.values);
        keep_every_second(column.sigmas);
    }
}

template <class Row>
void ReadoutPicture::add(const Row& row, Kind& kind) {
    double time_s = 0;
    std::uint64_t contact = 0;
    std::vector<std::pair<std::string, double>> numbers;
    row.columns([&](const std::string& name, const auto& value) {
        Overloaded{[&](TimePoint time) {
                       if (name == "time") time_s = seconds(time);
                   },
                   [&](std::uint32_t count) {
                       if (name == "contact") contact = count;
                   },
                   [&](double number) { numbers.emplace_back(name, number); },
                   [&](std::optional<double> number) { numbers.emplace_back(name, number.value_or(untold)); },
                   [](PatchIndex) {}}(value);
    });
    if (kind.columns.empty())
        for (const auto& each : numbers)
            if (const std::string of = column_of_sigma(each.first); !of.empty()) kind.columns.push_back(of);
    const double before_s = kind.curves[{row.patch.value, 0}].before_s;
    Curve& curve = kind.curves[{row.patch.value, contact}];
    // A second contact that was not told with the first one before has a gap there.
    const bool has_gap = contact > 0 && curve.seen > 0 && curve.last_s < before_s;
    curve.before_s = std::exchange(curve.last_s, time_s);
    if (curve.seen++ % curve.every != 0) return;
    if (has_gap) {
        auto none = numbers;
        for (auto& each : none) each.second = untold;
        curve.keep(before_s, none);
    }
    curve.keep(time_s, numbers);
}

void ReadoutPicture::step(const ControllerStep& step) {
    for (const PatchReadout& readout : step.readouts)
        std::visit([&](const auto& row) { add(row, kinds_[readout.index()]); }, readout);
}

bool ReadoutPicture::is_empty() const noexcept {
    return std::ranges::all_of(kinds_, [](const Kind& kind) { return kind.curves.empty(); });
}

std::string ReadoutPicture::name_of(std::uint32_t patch, std::uint64_t contact) const {
    return plan_.patches[patch].name + (contact > 0 ? ", second contact" : "");
}

// A column without any known value has no panel.
std::vector<PanelGrid::Panel> ReadoutPicture::panels_of(const Kind& kind, double end_s) const {
    std::vector<PanelGrid::Panel> panels;
    for (const std::string& name : kind.columns) {
        PanelGrid::Panel panel{
            .title = name, .x_title = "time [s]", .y_title = "", .curves = {}, .x_range = {{0, end_s}}};
        bool is_known = false;
        // Angles are drawn within half a turn of the first.
        const double turn = turn_of(name);
        double first = untold;
        for (const auto& [of, curve] : kind.curves) {
            const Column& column = curve.columns.at(name);
            PanelGrid::Curve drawn{.name = name_of(of.first, of.second),
                                   .x = curve.times_s,
                                   .y = column.values,
                                   .marked = curve.times_s.size() <= most_marked};
            for (std::size_t i = 0; i < column.values.size(); ++i) {
                double& value = drawn.y[i];
                if (!is_known) first = value;
                is_known = is_known || std::isfinite(value);
                if (turn > 0) value = first + std::remainder(value - first, turn);
                drawn.low.push_back(value - 2 * column.sigmas[i]);
                drawn.high.push_back(value + 2 * column.sigmas[i]);
            }
            panel.curves.push_back(std::move(drawn));
        }
        if (is_known) panels.push_back(std::move(panel));
    }
    return panels;
}

Drawing ReadoutPicture::draw(const std::filesystem::path& stem) const {
    double end_s = 0;
    for (const Kind& kind : kinds_)
        for (const auto& [of, curve] : kind.curves) end_s = std::max(end_s, curve.last_s);
    PanelGrid picture{.title = plan_.scene.name, .columns = 1, .panels = {}};
    std::vector<std::vector<PanelGrid::Panel>> rows;
    for (const Kind& kind : kinds_) {
        rows.push_back(panels_of(kind, end_s));
        picture.columns = std::max(picture.columns, rows.back().size());
    }
    for (auto& row : rows) {
        if (row.empty()) continue;
        row.resize(picture.columns);
        std::ranges::move(row, std::back_inserter(picture.panels));
    }
    return afferent::draw(picture, stem);
}

}  // namespace afferent
