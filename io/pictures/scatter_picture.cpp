#include "afferent/io/pictures/scatter_picture.hpp"

#include <array>
#include <map>

#include "afferent/io/pictures/figure.hpp"

namespace afferent {

Drawing draw(const ScatterPicture& picture, const std::filesystem::path& stem) {
    constexpr FigureSize size{1120, 560};
    if (picture.series.empty()) return {Drawn::failed, "there is nothing to draw"};

    GnuplotScript data;
    GnuplotScript body;
    body.line("reset");
    body.line("set logscale xy");
    body.line("set format xy '10^{%T}'");
    body.line("set tics nomirror out scale 0.5,0.25 textcolor rgb '", colour::axis, "'");
    body.line("set border 3 lw 0.8 lc rgb '", colour::axis, "'");
    body.line("set grid xtics ytics back lt 1 lw 0.6 lc rgb '", colour::grid, "'");
    body.line("set key outside right top Left reverse samplen 1.4 spacing 1.2 noenhanced textcolor rgb '",
              colour::axis, "'");
    // Room for the labels of the outermost points.
    body.line("set offsets graph 0.03, graph 0.08, graph 0.06, graph 0.03");
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
        for (const auto& [x, y, label] : points)
            if (x > 0 && y > 0) data.line(x, ' ', y, ' ', gnuplot_data_text(label));
        data.line("EOD");

        const std::string_view end = i + 1 < picture.series.size() ? ", \\" : "";
        if (!marked) {
            body.line(i == 0 ? "plot" : "    ", " $series", i, " using 1:2 with lines lw 1.2 dashtype ",
                      2 + dashes++, " lc rgb '", colour::axis, "' notitle, \\");
            body.line("     $series", i,
                      " using 1:2:3 with labels noenhanced right offset 0,-0.7 font note_font ",
                      "textcolor rgb '", colour::axis, "' notitle", end);
            continue;
        }
        const std::size_t chosen = kind.value_or(i) % colour::series.size();
        const std::string_view hue = colour::series[chosen];
        const int shape = shapes[(chosen + of_colour[chosen]++) % shapes.size()];
        body.line(i == 0 ? "plot" : "    ", " $series", i, " using 1:2 with ",
                  joined ? "linespoints" : "points", " lw 1.5 ps 0.7 pt ", shape, " lc rgb '", hue,
                  "' title ", gnuplot_text(name), ", \\");
        body.line("     $series", i,
                  " using 1:2:3 with labels noenhanced left offset 0.8,0.5 font note_font ",
                  "textcolor rgb '", hue, "' notitle", end);
    }
    return draw_figure(stem, size, data.text(), body);
}

}  // namespace afferent
