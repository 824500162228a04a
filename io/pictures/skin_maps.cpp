#include "afferent/io/pictures/skin_maps.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/io/pictures/figure.hpp"
#include "afferent/io/pictures/rate_colours.hpp"

namespace afferent {
namespace {

constexpr std::size_t most_across = 3;
constexpr int column_px = 400;
constexpr int head_px = 40;
constexpr double margin_mm = 1;

struct Box {
    double x_low, x_high, y_low, y_high;
};

Box around(const std::vector<Position>& places) {
    const auto [west, east] = std::ranges::minmax(places, {}, &Position::x_mm);
    const auto [south, north] = std::ranges::minmax(places, {}, &Position::y_mm);
    return {west.x_mm - margin_mm, east.x_mm + margin_mm, south.y_mm - margin_mm, north.y_mm + margin_mm};
}

bool has_colour(const SkinMaps::Map& map, double value) {
    return std::isfinite(value) && !(map.logarithmic && value <= 0);
}

// The values of a map that have a colour, and the places of those that have none.
void add_map(GnuplotScript& data, const SkinMaps& picture, std::size_t index) {
    const SkinMaps::Map& map = picture.maps[index];
    for (const bool coloured : {true, false}) {
        data.line(coloured ? "$values" : "$hollow", index, " << EOD");
        for (std::size_t i = 0; i < picture.places.size(); ++i)
            if (has_colour(map, map.values[i]) == coloured)
                data.line(picture.places[i].x_mm, ' ', picture.places[i].y_mm, ' ',
                          coloured ? map.values[i] : 0);
        data.line("EOD");
    }
}

struct Limits {
    double low = HUGE_VAL;
    double high = -HUGE_VAL;
};

Limits limits_of(const SkinMaps::Map& map) {
    Limits limits;
    for (const double value : map.values)
        if (has_colour(map, value)) limits = {std::min(limits.low, value), std::max(limits.high, value)};
    return limits;
}

// Where all values are alike there is no scale, and the title says which value that is.
std::string title_of(const SkinMaps::Map& map) {
    const auto [low, high] = limits_of(map);
    return low == high ? map.title + ": " + gnuplot_number(low) + " throughout" : map.title;
}

void scale_colours(GnuplotScript& body, const SkinMaps::Map& map) {
    const auto [low, high] = limits_of(map);
    if (!(low < high)) {
        const double middle = low == high ? low : 0;
        body.line("unset logscale cb");
        body.line("unset colorbox");
        body.line("set cbrange [", middle - 1, ':', middle + 1, ']');
        return;
    }
    body.line(map.logarithmic ? "set logscale cb" : "unset logscale cb");
    body.line("set colorbox");
    body.line("set cbrange [", low, ':', high, ']');
    // Three numbers, as a short range may contain no power of ten.
    const double middle = map.logarithmic ? std::sqrt(low * high) : (low + high) / 2;
    body.line("set cbtics (", low, ',', middle, ',', high, ") format '%.4g' scale 0.4");
}

}  // namespace

Drawing draw(const SkinMaps& picture, const std::filesystem::path& stem) {
    if (picture.places.empty() || picture.maps.empty()) return {Drawn::failed, "there is nothing to draw"};
    const Box box = around(picture.places);
    const double width_mm = box.x_high - box.x_low;
    const double height_mm = box.y_high - box.y_low;
    const double map_px = 0.68 * column_px;
    const double row_px = std::clamp(map_px * height_mm / width_mm, 120.0, 900.0) + 70;
    const std::size_t across = std::min(most_across, picture.maps.size());
    const std::size_t rows = (picture.maps.size() + most_across - 1) / most_across;
    const FigureSize size{static_cast<int>(across) * column_px,
                          head_px + static_cast<int>(row_px * static_cast<double>(rows))};

    GnuplotScript data;
    GnuplotScript body;
    body.line("reset");
    body.line("set multiplot");
    body.line("unset key");
    body.line("set border 3 lw 0.8 lc rgb '", colour::axis, "'");
    body.line("set tics nomirror out scale 0.5 textcolor rgb '", colour::axis, "'");
    body.line("set size ratio -1");
    std::string stops;
    for (std::size_t i = 0; i < rate_stops.size(); ++i) {
        const auto& [red, green, blue] = rate_stops[i];
        stops += i > 0 ? ", " : "";
        for (const double part : {static_cast<double>(i), red / 255, green / 255, blue / 255})
            stops += gnuplot_number(part) + ' ';
    }
    body.line("set palette defined (", stops, ')');
    body.line("set label ", gnuplot_text(picture.title), " at screen 0.5,", 1 - 20.0 / size.height,
              " center noenhanced font title_font textcolor rgb '", colour::axis, "'");
    // Marks take some two thirds of the distance between neighbours; one of size 1 is some 8 pixels wide.
    const double scale = std::min(map_px / width_mm, (row_px - 70) / height_mm);
    const double apart_px =
        scale * std::sqrt(width_mm * height_mm / static_cast<double>(picture.places.size()));
    const double mark = std::clamp(apart_px / 12, 0.25, 1.6);
    for (std::size_t i = 0; i < picture.maps.size(); ++i) {
        const SkinMaps::Map& map = picture.maps[i];
        add_map(data, picture, i);
        const double begin = static_cast<double>(i % most_across) / static_cast<double>(across);
        const double top = 1 - (head_px + row_px * static_cast<double>(i / most_across)) / size.height;
        const double width = 1.0 / static_cast<double>(across);
        const double height = row_px / size.height;
        body.line("set lmargin at screen ", begin + 0.13 * width);
        body.line("set rmargin at screen ", begin + 0.81 * width);
        body.line("set tmargin at screen ", top - 30.0 / size.height);
        body.line("set bmargin at screen ", top - height + 40.0 / size.height);
        put_letter(body, i, begin + 0.02 * width, top - 12.0 / size.height);
        body.line("set label ", gnuplot_text(title_of(map)), " at screen ", begin + 0.13 * width, ',',
                  top - 12.0 / size.height, " left noenhanced textcolor rgb '", colour::axis, "'");
        body.line("set xrange [", box.x_low, ':', box.x_high, ']');
        body.line("set yrange [", box.y_low, ':', box.y_high, ']');
        body.line("set xlabel 'x (mm)' offset 0,0.6 textcolor rgb '", colour::axis, "'");
        body.line("set ylabel 'y (mm)' offset 1,0 textcolor rgb '", colour::axis, "'");
        scale_colours(body, map);
        const bool coloured =
            std::ranges::any_of(map.values, [&](double value) { return has_colour(map, value); });
        const bool hollow =
            !std::ranges::all_of(map.values, [&](double value) { return has_colour(map, value); });
        body.line("plot ", coloured ? "$values" : "", coloured ? gnuplot_number(static_cast<double>(i)) : "",
                  coloured ? " using 1:2:3 with points pt 7 ps " : "", coloured ? gnuplot_number(mark) : "",
                  coloured ? " lc palette notitle" : "", coloured && hollow ? ", " : "",
                  hollow ? "$hollow" + gnuplot_number(static_cast<double>(i)) +
                               " using 1:2 with points pt 6 ps " + gnuplot_number(0.6 * mark) + " lc rgb '" +
                               std::string(colour::faint) + "' notitle"
                         : "");
        body.line("unset label");
    }
    body.line("unset multiplot");
    return draw_figure(stem, size, data.text(), body);
}

}  // namespace afferent
