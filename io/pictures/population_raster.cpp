// The lower half of the picture of a population: all spikes, by kind and place.
#include "afferent/io/pictures/plot_data.hpp"
#include "afferent/io/pictures/population_layout.hpp"

namespace afferent {
namespace {

class Raster {
  public:
    Raster(const PopulationPicture& picture, const PopulationLayout& layout, std::string& data)
        : picture_(picture), layout_(layout) {
        const auto& kinds = picture.rows.kinds();
        std::vector<SpikeDensity::Hue> hues;
        for (std::size_t i = 0; i < kinds.size(); ++i)
            hues.push_back({kinds[i].first, kinds[i].rows, colour_of_kind(kinds, i)});
        if (picture.density)
            data += picture.density->data("$spikes", hues);
        else
            data += spike_data("$spikes", picture.events, 0, picture.end_s, picture.rows.rows());
        if (picture.passing) add_passing(data);
    }

    GnuplotScript script() const {
        GnuplotScript body;
        const auto& kinds = picture_.rows.kinds();
        const std::uint32_t rows = picture_.rows.rows();
        layout_.margins(body, left_px, right_px, layout_.raster_top, layout_.raster_top + raster_px);
        body.line("set border 3 lw 0.8 lc rgb '", colour::axis, "'");
        body.line("set xtics nomirror out scale 0.5", axis_text);
        body.line("set format x '%g'");
        body.line("set xrange [0:", picture_.end_s, ']');
        // The first row is on top, so that kinds have the order of the maps.
        body.line("set yrange [", rows - 0.5, ":-0.5]");
        body.line("set xlabel 'Time (s)' offset 0,0.4", axis_text);
        body.line("set label ", gnuplot_text("Position " + picture_.direction + " (mm), by kind"),
                  " at screen ", 16 / figure_width, ',', layout_.y(layout_.raster_top + raster_px / 2),
                  " center rotate noenhanced", axis_text);
        put_letter(body, kinds.size(), layout_.x(left_px - 50), layout_.y(layout_.raster_top - 12));
        add_tics(body);
        body.line("set object rectangle from first ", picture_.from_s, ", graph 0 to first ", picture_.to_s,
                  ", graph 1 behind fs solid 1 noborder fc rgb '#F3ECDD'");
        for (std::size_t i = 0; i < kinds.size(); ++i) add_kind(body, i);
        add_note(body);
        std::string curves;
        const auto plot = [&](const std::string& clause) {
            curves += (curves.empty() ? "plot " : ", \\\n     ") + clause;
        };
        if (picture_.density) {
            plot("$spikes using 1:2:3:4:5 with rgbimage notitle");
        } else {
            // A mark is a little shorter than its row, but never too short to be seen.
            const double half = std::max(0.4, rows / 300.0);
            for (std::size_t i = 0; i < kinds.size(); ++i)
                plot("$spikes using ($2 >= " + std::to_string(kinds[i].first) + " && $2 < " +
                     std::to_string(kinds[i].first + kinds[i].rows) + " ? $1 : NaN):($2 - " +
                     gnuplot_number(half) + "):(0):(" + gnuplot_number(2 * half) +
                     ") with vectors nohead lw 0.9 lc rgb '" + std::string(colour_of_kind(kinds, i)) +
                     "' notitle");
        }
        if (picture_.passing)
            plot("$passing with lines lw 1.1 dt (6,4) lc rgb '" + std::string(colour::axis) + "' notitle");
        body.line(curves);
        body.line("unset label");
        body.line("unset object");
        body.line("unset arrow");
        return body;
    }

  private:
    // When the middle of what passes is over the place of each row.
    void add_passing(std::string& data) const {
        data += "$passing << EOD\n";
        for (const auto& [name, first, rows] : picture_.rows.kinds()) {
            for (std::uint32_t row = first; row < first + rows; ++row) {
                const double time_s = (picture_.rows.along_mm(row) - picture_.passing->begin_mm) /
                                      picture_.passing->speed_mm_per_s;
                if (time_s >= 0 && time_s <= picture_.end_s)
                    data += gnuplot_number(time_s) + ' ' + gnuplot_number(row) + '\n';
            }
            data += '\n';
        }
        data += "EOD\n";
    }

    // The places of the first and the last row of each kind, and of the row nearest to 0.
    void add_tics(GnuplotScript& body) const {
        std::string tics;
        const auto tic = [&](double row, double mm) {
            if (!std::isfinite(mm)) return;
            std::array<char, 16> text{};
            std::snprintf(text.data(), text.size(), "%.1f", mm == 0 ? 0.0 : mm);
            tics += (tics.empty() ? "" : ", ") + gnuplot_text(text.data()) + ' ' + gnuplot_number(row);
        };
        for (const auto& [name, first, rows] : picture_.rows.kinds()) {
            if (rows == 0) continue;
            const double line_rows = 16.0 / raster_px * picture_.rows.rows();
            tic(first + std::min(line_rows / 3, rows / 2.0), picture_.rows.along_mm(first));
            if (rows > 2 * line_rows)
                tic(first + rows - 1 - line_rows / 3, picture_.rows.along_mm(first + rows - 1));
        }
        body.line("set ytics scale 0 noenhanced (", tics, ')', axis_text);
    }

    void add_kind(GnuplotScript& body, std::size_t kind) const {
        const auto& [name, first, rows] = picture_.rows.kinds()[kind];
        if (first > 0)
            body.line("set arrow from graph 0, first ", first - 0.5, " to graph 1, first ", first - 0.5,
                      " nohead front lw 0.8 lc rgb '", colour::axis, "'");
        const double middle_px = layout_.raster_top + raster_px * (first + rows / 2.0) / picture_.rows.rows();
        body.line("set label ", gnuplot_text(name), " at screen ", layout_.x(legend_px), ',',
                  layout_.y(middle_px - 8), " left noenhanced textcolor rgb '",
                  colour_of_kind(picture_.rows.kinds(), kind), "'");
        body.line("set label ", gnuplot_text(with_thousands(picture_.spikes_of_kind[kind]) + " spikes"),
                  " at screen ", layout_.x(legend_px), ',', layout_.y(middle_px + 8), " left noenhanced",
                  axis_text);
    }

    void add_note(GnuplotScript& body) const {
        std::string note = "shaded: the span above";
        if (picture_.passing) note += "; dashed: " + picture_.passing->name + " passes";
        if (picture_.density)
            note = with_thousands(picture_.all_spikes) +
                   " spikes, too many to draw one by one: the shade is the mean rate, full colour at " +
                   short_number(picture_.density->peak_hz()) + " Hz a neuron" +
                   (picture_.passing ? "; dashed: " + picture_.passing->name + " passes" : "");
        body.line("set label ", gnuplot_text(note), " at screen ", layout_.x(left_px), ',',
                  layout_.y(layout_.raster_top - 12), " left noenhanced font note_font", axis_text);
    }

    const PopulationPicture& picture_;
    const PopulationLayout& layout_;
};

}  // namespace

GnuplotScript population_raster(const PopulationPicture& picture, const PopulationLayout& layout,
                                std::string& data) {
    return Raster(picture, layout, data).script();
}

}  // namespace afferent
