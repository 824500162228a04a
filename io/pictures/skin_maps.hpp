// Maps of the skin: what is found at the place of each afferent, in colours.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "afferent/io/pictures/gnuplot.hpp"
#include "afferent/runtime/position.hpp"

namespace afferent {

struct SkinMaps {
    struct Map {
        std::string title;           // with the unit
        std::vector<double> values;  // one for each place; NaN, or what has no logarithm, is hollow
        bool logarithmic = false;
    };

    std::string title;
    std::vector<Position> places;
    std::vector<Map> maps;  // three in a row
};

// Writes <stem>.svg and <stem>.png.
Drawing draw(const SkinMaps& picture, const std::filesystem::path& stem);

}  // namespace afferent
