// Bars side by side: what several series give for each of a few names, with intervals.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "afferent/io/pictures/gnuplot.hpp"

namespace afferent {

struct BarPicture {
    struct Bar {
        double value;
        double low;  // of its interval
        double high;
    };
    struct Series {
        std::string name;
        std::vector<std::optional<Bar>> bars;  // one for each name; none: there is nothing to draw
        // True: in grey, as a reference for the others.
        bool is_reference = false;
    };

    std::string title;
    std::string y_title;  // with its unit
    std::vector<std::string> names;
    std::vector<Series> series;
    std::string note;  // below the bars; may be empty
};

// Writes <stem>.svg and <stem>.png. The axis begins at 0, and no value is negative.
Drawing draw(const BarPicture& picture, const std::filesystem::path& stem);

}  // namespace afferent
