// The picture of a benchmark: series of points over two logarithmic axes, or over names.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "afferent/io/pictures/gnuplot.hpp"

namespace afferent {

struct ScatterPicture {
    struct Point {
        double x;
        double y;
    };
    struct Series {
        std::string name;
        std::vector<Point> points;
        bool joined = true;  // by a line, in the order given
        // Series of one kind have one colour, and differ in their shapes. Without a kind a series has a
        // colour of its own.
        std::optional<std::size_t> kind = {};
        // False: a dashed grey line, as a reference for the others.
        bool marked = true;
    };

    std::string title;
    std::string x_title;  // with its unit
    std::string y_title;
    std::vector<Series> series;
    // Of x = 1, 2, ...: in place of a logarithmic axis with numbers.
    std::vector<std::string> x_names = {};
};

// Writes <stem>.svg and <stem>.png. Points that are not positive have no place on the axes and are left out.
Drawing draw(const ScatterPicture& picture, const std::filesystem::path& stem);

}  // namespace afferent
