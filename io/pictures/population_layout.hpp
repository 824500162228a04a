// What the two halves of the picture of a population have in common. Only its sources include this.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <string>

#include "afferent/io/pictures/figure.hpp"
#include "afferent/io/pictures/gnuplot_script.hpp"
#include "afferent/io/pictures/population_picture.hpp"

namespace afferent {

// In pixels of the SVG. Maps stand side by side in the space left of the legends, and the raster below them.
inline constexpr double figure_width = 1120;
inline constexpr double left_px = 66;
inline constexpr double right_px = 940;
inline constexpr double legend_px = 962;
inline constexpr double map_gap_px = 22;
inline constexpr double highest_map_px = 330;
inline constexpr std::size_t most_columns = 3;
inline constexpr double title_px = 40;
inline constexpr double map_title_px = 26;
inline constexpr double scale_bar_px = 30;
inline constexpr double raster_top_px = 30;  // between maps and raster
inline constexpr double raster_px = 380;
inline constexpr double bottom_px = 50;

struct MapBox {
    double x_low = std::numeric_limits<double>::infinity();
    double x_high = -std::numeric_limits<double>::infinity();
    double y_low = std::numeric_limits<double>::infinity();
    double y_high = -std::numeric_limits<double>::infinity();

    void add(const Position& place, double around_mm) {
        x_low = std::min(x_low, place.x_mm - around_mm);
        x_high = std::max(x_high, place.x_mm + around_mm);
        y_low = std::min(y_low, place.y_mm - around_mm);
        y_high = std::max(y_high, place.y_mm + around_mm);
    }
    double width() const { return x_high - x_low; }
    double height() const { return y_high - y_low; }
};

inline MapBox box_of(const PopulationPicture& picture) {
    MapBox box;
    for (const auto& outline : picture.skin.outlines)
        for (const Position& corner : outline) box.add(corner, 0);
    for (const Population::Afferent& each : picture.population.afferents)
        if (each.place) box.add(*each.place, 0);
    const double margin_mm = 0.02 * std::max({box.width(), box.height(), 0.1});
    box.add({box.x_low, box.y_low}, margin_mm);
    box.add({box.x_high, box.y_high}, margin_mm);
    return box;
}

// Where everything stands.
struct PopulationLayout {
    MapBox box;
    std::size_t columns;
    std::size_t map_rows;
    double px_per_mm;
    double maps_top;
    double raster_top;
    double height;

    explicit PopulationLayout(const PopulationPicture& picture) : box(box_of(picture)) {
        const std::size_t kinds = picture.rows.kinds().size();
        columns = std::min(kinds, most_columns);
        map_rows = (kinds + columns - 1) / columns;
        const double room = (right_px - left_px + map_gap_px) / static_cast<double>(columns) - map_gap_px;
        px_per_mm = std::min(room / box.width(), highest_map_px / box.height());
        maps_top = picture.title.empty() ? 10 : title_px;
        raster_top = maps_top + static_cast<double>(map_rows) * row_px() + raster_top_px;
        height = std::round(raster_top + raster_px + bottom_px);
    }

    double row_px() const { return map_title_px + box.height() * px_per_mm + scale_bar_px; }
    double map_left(std::size_t kind) const {
        const double pitch = (right_px - left_px + map_gap_px) / static_cast<double>(columns);
        return left_px + static_cast<double>(kind % columns) * pitch;
    }
    double map_top(std::size_t kind) const {
        return maps_top + map_title_px + static_cast<double>(kind / columns) * row_px();
    }
    // As gnuplot counts: shares of the figure, from its lower left.
    double x(double px) const { return px / figure_width; }
    double y(double px) const { return 1 - px / height; }

    // Of the next plot, in pixels.
    void margins(GnuplotScript& body, double x_low, double x_high, double y_top, double y_bottom) const {
        body.line("set lmargin at screen ", x(x_low));
        body.line("set rmargin at screen ", x(x_high));
        body.line("set tmargin at screen ", y(y_top));
        body.line("set bmargin at screen ", y(y_bottom));
    }
};

inline const std::string axis_text = " textcolor rgb '" + std::string(colour::axis) + "'";

// 7 digits are too many for a legend.
inline std::string short_number(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.3g", value);
    return text.data();
}

inline std::string with_thousands(std::uint64_t number) {
    const std::string digits = std::to_string(number);
    std::string text;
    for (std::size_t i = 0; i < digits.size(); ++i) {
        if (i > 0 && (digits.size() - i) % 3 == 0) text += ',';
        text += digits[i];
    }
    return text;
}

// Each adds what it plots to the data.
GnuplotScript population_maps(const PopulationPicture& picture, const PopulationLayout& layout,
                              std::string& data);
GnuplotScript population_raster(const PopulationPicture& picture, const PopulationLayout& layout,
                                std::string& data);

}  // namespace afferent
