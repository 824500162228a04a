// What all pictures share: two files, a size, fonts and colours.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <string_view>

#include "afferent/io/pictures/gnuplot.hpp"
#include "afferent/io/pictures/gnuplot_script.hpp"

namespace afferent {

// Okabe and Ito's colours, which people of any colour vision tell apart, with a brown in place of their
// yellow: it hardly shows on white.
namespace colour {
inline constexpr std::string_view blue = "#0072B2";
inline constexpr std::string_view pale_blue = "#CCE3F0";  // blue at a fifth of its strength
inline constexpr std::string_view orange = "#E69F00";
inline constexpr std::string_view green = "#009E73";
inline constexpr std::string_view vermilion = "#D55E00";
inline constexpr std::string_view purple = "#CC79A7";
inline constexpr std::string_view sky = "#56B4E9";
inline constexpr std::string_view brown = "#7A4B00";
inline constexpr std::string_view black = "#000000";
// The range of a curve of that colour: half of its strength.
inline constexpr std::string_view half_blue = "#80B8D8";
inline constexpr std::string_view half_vermilion = "#EAAE80";
// For several things of one kind, in this order.
inline constexpr std::array series{blue, orange, green, vermilion, sky, purple, black, brown};
// The colours of sustained and of transient afferents. They have none in common, and none with the estimate.
inline constexpr std::array sustained{orange, green, purple};
inline constexpr std::array transient{vermilion, sky, black};
// Axes and their text, and things in the background.
inline constexpr std::string_view axis = "#404040";
inline constexpr std::string_view grid = "#E4E4E4";
inline constexpr std::string_view faint = "#B8B8B8";
}  // namespace colour

// The letter by which a text refers to the panel, "A" for the first; in shares of the figure, left and below.
// There are 26.
void put_letter(GnuplotScript& body, std::size_t panel, double x, double y);

// 1, 2 or 5 times a power of ten, at most `value` and more than two fifths of it.
double round_below(double value);

struct FigureSize {
    int width;
    int height;  // in pixels of the SVG; the PNG has twice as many
};

// Runs the body twice, to draw <stem>.svg and <stem>.png; both read the data. The body may use title_font and
// note_font.
Drawing draw_figure(const std::filesystem::path& stem, FigureSize size, std::string_view data,
                    const GnuplotScript& body);

}  // namespace afferent
