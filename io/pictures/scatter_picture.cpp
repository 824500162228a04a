#include "afferent/io/pictures/scatter_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "afferent/io/pictures/figure.hpp"

namespace afferent {
namespace {

// What an axis has to show; empty: nothing.
struct Range {
    double low = std::numeric_limits<double>::infinity();
    double high = 0;

    void add(double value) {
        low = std::min(low, value);
        high = std::max(high, value);
    }
};

// "0.2", "50"; far from one "2·10^{-7}", as gnuplot's enhanced text has it.
std::string tic_name(int times, int power) {
    if (power >= -3 && power <= 4) return gnuplot_number(times * std::pow(10, power));
    return (times > 1 ? std::to_string(times) + "·" : "") + "10^{" + std::to_string(power) + '}';
}

// Ends the axis a little beyond the points, and not at the next power of ten. Where powers of ten are rare,
// 2 and 5 times each have their tics.
void scale_axis(GnuplotScript& body, char axis, Range range) {
    if (range.low > range.high) range = {1, 10};
    const double decades = std::log10(range.high / range.low);
    const double margin = std::pow(10, std::max(0.05 * decades, 0.1));
    body.line("set ", axis, "range [", range.low / margin, ':', range.high * margin, ']');
    if (decades >= 2) return;
    std::string tics;
    for (int power = static_cast<int>(std::floor(std::log10(range.low))) - 1;
         std::pow(10, power) < range.high * margin; ++power)
        for (const int times : {1, 2, 5})
            tics += (tics.empty() ? "'" : ", '") + tic_name(times, power) + "' " +
                    gnuplot_number(times * std::pow(10, power));
    body.line("set ", axis, "tics (", tics, ')');
}

void name_axis(GnuplotScript& body, const std::vector<std::string>& names) {
    std::string tics;
    for (std::size_t i = 0; i < names.size(); ++i)
        tics += (i > 0 ? ", " : "") + gnuplot_text(names[i]) + ' ' + std::to_string(i + 1);
    body.line("unset logscale x");
    body.line("set xrange [0.5:", static_cast<double>(names.size()) + 0.5, ']');
    body.line("set xtics (", tics, ") rotate by -45 left noenhanced");
}

}  // namespace

Drawing draw(const ScatterPicture& picture, const std::filesystem::path& stem) {
    // The legend stays in one column beside the axes, however many series there are: a second one would leave
    // no room for them.
    constexpr int series_in_height = 26;
    constexpr int legend_line = 18;
    const int more = std::max(0, static_cast<int>(picture.series.size()) - series_in_height);
    const FigureSize size{1120, 560 + legend_line * more};
    if (picture.series.empty()) return {Drawn::failed, "there is nothing to draw"};

    GnuplotScript data;
    GnuplotScript body;
    body.line("reset");
    body.line("set logscale xy");
    body.line("set format xy '10^{%T}'");
    body.line("set tics nomirror out scale 0.5,0.25 textcolor rgb '", colour::axis, "'");
    body.line("set border 3 lw 0.8 lc rgb '", colour::axis, "'");
    body.line("set grid xtics ytics back lt 1 lw 0.6 lc rgb '", colour::grid, "'");
    // Long enough to tell dashes apart, where there are any.
    const bool dashed = !std::ranges::all_of(picture.series, &ScatterPicture::Series::marked);
    body.line("set key outside right top Left reverse samplen ", dashed ? 3.5 : 1.4,
              " spacing 1.2 noenhanced textcolor rgb '", colour::axis, "'");
    Range x_range;
    Range y_range;
    for (const auto& series : picture.series)
        for (const auto& [x, y] : series.points) {
            if (!(x > 0 && y > 0)) continue;
            x_range.add(x);
            y_range.add(y);
        }
    if (picture.x_names.empty())
        scale_axis(body, 'x', x_range);
    else
        name_axis(body, picture.x_names);
    scale_axis(body, 'y', y_range);
    const auto title = [&body](std::string_view what, const std::string& text, std::string_view font) {
        if (!text.empty())
            body.line("set ", what, ' ', gnuplot_text(text), " noenhanced textcolor rgb '", colour::axis,
                      "' ", font);
    };
    title("title", picture.title, "font title_font");
    title("xlabel", picture.x_title, "");
    title("ylabel", picture.y_title, "");

    // Shapes differ as well as colours, for prints in black and white. Series of one colour take different
    // shapes. The second half repeats the first, hollow.
    constexpr std::array shapes{7, 5, 9, 13, 11, 15, 6, 4, 8, 12, 10, 14};
    std::map<std::size_t, std::size_t> of_colour;
    int dashes = 0;
    for (std::size_t i = 0; i < picture.series.size(); ++i) {
        const auto& [name, points, joined, kind, marked] = picture.series[i];
        data.line("$series", i, " << EOD");
        for (const auto& [x, y] : points)
            if (x > 0 && y > 0) data.line(x, ' ', y);
        data.line("EOD");

        const std::string_view begin = i == 0 ? "plot" : "    ";
        const std::string_view end = i + 1 < picture.series.size() ? ", \\" : "";
        if (!marked) {
            body.line(begin, " $series", i, " with lines lw 1.2 dashtype ", 2 + dashes++, " lc rgb '",
                      colour::axis, "' title ", gnuplot_text(name), end);
            continue;
        }
        const std::size_t chosen = kind.value_or(i) % colour::series.size();
        const std::string_view hue = colour::series[chosen];
        const int shape = shapes[(chosen + of_colour[chosen]++) % shapes.size()];
        body.line(begin, " $series", i, " with ", joined ? "linespoints" : "points", " lw 1.5 ps 0.7 pt ",
                  shape, " lc rgb '", hue, "' title ", gnuplot_text(name), end);
    }
    return draw_figure(stem, size, data.text(), body);
}

}  // namespace afferent
