#include <algorithm>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <stdexcept>

#include "afferent/io/pictures/figure.hpp"
#include "bench/scheme_map.hpp"

namespace afferent {
namespace {

struct Shown {
    const char* scheme;
    const char* name;
    std::string_view hue;
};
constexpr std::array shown{Shown{"events", "events", colour::blue},
                           Shown{"predicted", "predicted", colour::sky},
                           Shown{"send_on_delta", "send-on-delta", colour::orange},
                           Shown{"linear_prediction", "from a line", colour::purple},
                           Shown{"dead_band", "dead band", colour::vermilion},
                           Shown{"delta_coded", "differences", colour::green},
                           Shown{"raw12", "12-bit", colour::brown},
                           Shown{"", "none", colour::faint}};

// What the map calls a cell: the two codes of differences are one there.
std::string_view kind_of_cheapest(const MapCell& cell) {
    if (!cell.cheapest()) return "";
    return cell.cheapest()->scheme == "delta_varint" ? "delta_coded"
                                                     : std::string_view(cell.cheapest()->scheme);
}

// How many times the bytes of the cheapest alternative events take.
std::string events_over_best(const MapCell& cell) {
    double events = 0;
    double best = 0;
    for (const auto& [scheme, bytes_per_s] : cell.costs) {
        double& least = is_of_events(scheme) ? events : best;
        if (least == 0) least = bytes_per_s;
    }
    if (events == 0) return "-";
    std::ostringstream text;
    text << std::setprecision(2) << events / best;
    return text.str();
}

}  // namespace

void draw_map(const std::vector<MapCell>& map, double error_n, const std::filesystem::path& folder) {
    std::vector<Duration> delays;
    for (const MapCell& cell : map)
        if (std::find(delays.begin(), delays.end(), cell.allowed_delay) == delays.end())
            delays.push_back(cell.allowed_delay);
    GnuplotScript data;
    GnuplotScript body;
    const std::size_t columns = (delays.size() + 1) / 2;
    body.line("reset");
    body.line("set multiplot layout 2,", columns,
              " margins 0.07,0.98,0.14,0.9 spacing 0.08,0.15 title 'Fewest bytes at an RMS error of ",
              error_n,
              " N; numbers: the bytes of events over those of the best alternative' font title_font");
    body.line("set logscale xy");
    body.line("set format x '10^{%T}'");
    body.line("set tics nomirror out scale 0.5,0 textcolor rgb '", colour::axis, "'");
    body.line("set border 3 lw 0.8 lc rgb '", colour::axis, "'");
    body.line("set xrange [0.3:40000]");
    body.line("set yrange [0.5:220]");
    body.line("set xlabel 'elements' textcolor rgb '", colour::axis, "'");
    body.line("set ylabel 'touched in the mean, %' textcolor rgb '", colour::axis, "'");
    body.line(
        "set key at screen 0.5,0.02 center bottom horizontal maxrows 1 noenhanced samplen 0.5 textcolor rgb "
        "'",
        colour::axis, "'");
    for (std::size_t d = 0; d < delays.size(); ++d) {
        for (std::size_t s = 0; s < shown.size(); ++s) {
            data.line("$cells", d, "_", s, " << EOD");
            for (const MapCell& cell : map)
                if (cell.allowed_delay == delays[d] && cell.error_n == error_n &&
                    kind_of_cheapest(cell) == shown[s].scheme)
                    data.line(cell.elements, ' ', 100 * cell.activity, ' ',
                              gnuplot_data_text(events_over_best(cell)));
            // A block without rows cannot be drawn.
            data.line("1e-9 1e-9 \"\"");
            data.line("EOD");
        }
        body.line("set title 'allowed delay ", Milliseconds(delays[d]).count(), " ms' textcolor rgb '",
                  colour::axis, "'");
        for (std::size_t s = 0; s < shown.size(); ++s) {
            body.line(s == 0 ? "plot" : "    ", " $cells", d, "_", s,
                      " using 1:2 with points pt 5 ps 3.4 lc rgb '", shown[s].hue, "' notitle, \\");
            // The key's own squares are smaller, and are drawn once.
            if (d == 0)
                body.line("     NaN with points pt 5 ps 1.5 lc rgb '", shown[s].hue, "' title ",
                          gnuplot_text(shown[s].name), ", \\");
            body.line("     $cells", d, "_", s,
                      " using 1:2:3 with labels noenhanced font note_font textcolor rgb '", colour::black,
                      "' notitle", s + 1 < shown.size() ? ", \\" : "");
        }
    }
    body.line("unset multiplot");
    const Drawing drawing = draw_figure(folder / "map", {1000, 800}, data.text(), body);
    if (drawing.outcome == Drawn::no_gnuplot) std::cerr << "gnuplot is not installed: no picture\n";
    if (drawing.outcome == Drawn::failed) throw std::runtime_error(drawing.message);
}

}  // namespace afferent
