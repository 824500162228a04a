// Small panels in rows and columns, with curves that have the same colour and name in all of them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "afferent/io/pictures/gnuplot.hpp"

namespace afferent {

struct PanelGrid {
    // Points that are joined. NaN leaves a gap.
    struct Curve {
        std::string name;  // equal names are named once, and have one colour
        std::vector<double> x;
        std::vector<double> y;
        // A band around it; empty: none.
        std::vector<double> low = {};
        std::vector<double> high = {};
        bool marked = false;  // each point by a dot
        bool dashed = false;
    };
    // A dashed grey line across the panel, such as a limit.
    struct Level {
        std::string name;
        double value;
        bool upright = false;  // at that x, and not at that y
    };
    struct Panel {
        std::string title;    // may be empty, as may the others
        std::string x_title;  // with its unit
        std::string y_title;
        std::vector<Curve> curves;
        std::vector<Level> levels = {};
        // None: what the curves need, from 0 on where none of them is negative.
        std::optional<std::pair<double, double>> y_range = {};
        std::optional<std::pair<double, double>> x_range = {};  // none: that of the curves
        bool logarithmic_x = false;
    };

    std::string title;
    std::size_t columns = 1;
    std::vector<Panel> panels;  // row by row; one without curves leaves its place empty
    double panel_height = 184;  // in pixels of the SVG
};

// Writes <stem>.svg and <stem>.png.
Drawing draw(const PanelGrid& picture, const std::filesystem::path& stem);

}  // namespace afferent
