#include "afferent/io/pictures/population_picture.hpp"

#include "afferent/io/pictures/population_layout.hpp"

namespace afferent {

Drawing draw(const PopulationPicture& picture, const std::filesystem::path& stem) {
    if (!picture.population.has_positions()) return {Drawn::failed, "no afferent has a place"};
    const PopulationLayout layout(picture);
    std::string data;
    const GnuplotScript maps = population_maps(picture, layout, data);
    const GnuplotScript raster = population_raster(picture, layout, data);
    GnuplotScript body;
    body.line("reset");
    body.line("set multiplot");
    if (!picture.title.empty())
        body.line("set label ", gnuplot_text(picture.title), " at screen ", layout.x(left_px), ',',
                  layout.y(18), " left noenhanced font title_font", axis_text);
    body.append(maps);
    body.append(raster);
    body.line("unset multiplot");
    return draw_figure(stem, {static_cast<int>(figure_width), static_cast<int>(layout.height)}, data, body);
}

}  // namespace afferent
