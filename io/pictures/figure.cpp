#include "afferent/io/pictures/figure.hpp"

#include <cmath>

namespace afferent {

void put_letter(GnuplotScript& body, std::size_t panel, double x, double y) {
    if (panel >= 26) return;
    body.line("set label '{/:Bold ", static_cast<char>('A' + panel), "}' at screen ", x, ',', y,
              " left font title_font textcolor rgb '", colour::axis, "'");
}

double round_below(double value) {
    const double power = std::pow(10, std::floor(std::log10(value)));
    return power * (value >= 5 * power ? 5 : value >= 2 * power ? 2 : 1);
}

Drawing draw_figure(const std::filesystem::path& stem, FigureSize size, std::string_view data,
                    const GnuplotScript& body) {
    GnuplotScript script;
    script.line("set encoding utf8");
    script.line("set minussign");
    script.line(data);
    // `text_size` is in the terminal's own unit: pixels of the SVG, points of 96/72 such pixels in the PNG.
    const auto draw_as = [&](std::string_view terminal, std::string_view fonts, double text_size, int scale,
                             const char* ending) {
        script.line("title_font = ',", 1.2 * text_size, "'");
        script.line("note_font = ',", 0.85 * text_size, "'");
        script.line("set terminal ", terminal, " enhanced background rgb 'white' size ", scale * size.width,
                    ',', scale * size.height, " font '", fonts, ',', text_size, "'");
        script.line("set output ", gnuplot_text(stem.string() + ending));
        script.append(body);
        script.line("unset output");
    };
    // Liberation Sans is free and has the shapes of Arial, which is found elsewhere.
    draw_as("svg", "Liberation Sans, Arial, Helvetica, sans-serif", 12, 1, ".svg");
    draw_as("pngcairo fontscale 2 linewidth 2 pointscale 2", "Liberation Sans", 9, 2, ".png");
    return run_gnuplot(script.text());
}

}  // namespace afferent
