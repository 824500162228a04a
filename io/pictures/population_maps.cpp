// The upper half of the picture of a population: a map of the skin for each kind of afferent.
#include "afferent/io/pictures/population_layout.hpp"
#include "afferent/io/pictures/rate_colours.hpp"

namespace afferent {
namespace {

// More marks than this on one map overlap: then squares of skin have the mean rate of their afferents.
constexpr std::size_t most_marks = 3000;
constexpr int squares_across = 90;

// Ends at a round number at or above the highest rate.
double scale_of(double highest_hz) {
    if (!(highest_hz > 0)) return 1;
    const double step = round_below(highest_hz / 2);
    return step * std::ceil(highest_hz / step - 1e-9);
}

// A mark of a map: an afferent, or a square of many.
struct Mark {
    Position place;
    double rate_hz;
};

struct Map {
    std::vector<Mark> marks;
    double square_mm = 0;  // of each mark; 0: a mark is an afferent
    std::size_t afferents = 0;
};

std::vector<Map> maps_of(const PopulationPicture& picture, const PopulationLayout& layout) {
    const double span_s = picture.to_s - picture.from_s;
    std::vector<Map> maps(picture.rows.kinds().size());
    for (Address address = 0; address < picture.population.afferents.size(); ++address) {
        const auto& place = picture.population.afferents[address].place;
        if (!place) continue;
        Map& map = maps[picture.rows.kind(address)];
        ++map.afferents;
        map.marks.push_back({*place, picture.spikes[address] / span_s});
    }
    for (Map& map : maps) {
        if (map.marks.size() <= most_marks) continue;
        map.square_mm = std::max(layout.box.width(), layout.box.height()) / squares_across;
        const auto column = [&](const Mark& mark) {
            return std::floor((mark.place.x_mm - layout.box.x_low) / map.square_mm);
        };
        const auto row = [&](const Mark& mark) {
            return std::floor((mark.place.y_mm - layout.box.y_low) / map.square_mm);
        };
        std::ranges::sort(map.marks, [&](const Mark& a, const Mark& b) {
            return std::pair(row(a), column(a)) < std::pair(row(b), column(b));
        });
        std::vector<Mark> squares;
        for (std::size_t begin = 0; begin < map.marks.size();) {
            std::size_t end = begin;
            double sum_hz = 0;
            for (; end < map.marks.size() && row(map.marks[end]) == row(map.marks[begin]) &&
                   column(map.marks[end]) == column(map.marks[begin]);
                 ++end)
                sum_hz += map.marks[end].rate_hz;
            squares.push_back({{layout.box.x_low + (column(map.marks[begin]) + 0.5) * map.square_mm,
                                layout.box.y_low + (row(map.marks[begin]) + 0.5) * map.square_mm},
                               sum_hz / static_cast<double>(end - begin)});
            begin = end;
        }
        map.marks = std::move(squares);
    }
    return maps;
}

// Elements under pressure, in greys up to half black at the highest. Returns that, in kPa.
double add_pressure(const PopulationPicture& picture, std::string& data) {
    const auto kpa = [&](const PressureFrames::Pressed& each) {
        return picture.skin.elements[each.element].pressure_kpa(each.force_n);
    };
    double highest = 0;
    for (const auto& each : picture.pressed) highest = std::max(highest, kpa(each));
    data += "$pressed << EOD\n";
    for (const auto& each : picture.pressed) {
        if (kpa(each) <= 0) continue;
        const auto& [place, width_mm] = picture.skin.elements[each.element];
        const double grey = std::round(242 - 92 * kpa(each) / highest);
        for (const double value : {place.x_mm, place.y_mm, width_mm / 2, grey * 65793})
            data += gnuplot_number(value) + ' ';
        data += '\n';
    }
    data += "EOD\n";
    return highest;
}

void add_outlines(const PopulationPicture& picture, std::string& data) {
    data += "$outline << EOD\n";
    for (const auto& outline : picture.skin.outlines) {
        for (std::size_t i = 0; i <= outline.size(); ++i) {
            const Position& corner = outline[i % outline.size()];
            data += gnuplot_number(corner.x_mm) + ' ' + gnuplot_number(corner.y_mm) + '\n';
        }
        data += '\n';
    }
    data += "EOD\n";
}

// The shapes of the kinds, filled; the next one up or down is hollow.
struct Shape {
    int filled;
    int hollow;
};
constexpr std::array<Shape, 5> kind_shapes{{{7, 6}, {9, 8}, {13, 12}, {5, 4}, {11, 10}}};

class Maps {
  public:
    Maps(const PopulationPicture& picture, const PopulationLayout& layout, std::string& data)
        : picture_(picture), layout_(layout), maps_(maps_of(picture, layout)) {
        add_outlines(picture, data);
        highest_kpa_ = add_pressure(picture, data);
        double highest_hz = 0;
        for (const Map& map : maps_)
            for (const Mark& mark : map.marks) highest_hz = std::max(highest_hz, mark.rate_hz);
        scale_hz_ = scale_of(highest_hz);
        for (std::size_t kind = 0; kind < maps_.size(); ++kind) {
            for (const bool fires : {true, false}) {
                data += name_of(kind, fires) + " << EOD\n";
                for (const Mark& mark : maps_[kind].marks)
                    if (fires == (mark.rate_hz > 0))
                        data += gnuplot_number(mark.place.x_mm) + ' ' + gnuplot_number(mark.place.y_mm) +
                                ' ' + gnuplot_number(rate_colour(mark.rate_hz / scale_hz_)) + '\n';
                data += "EOD\n";
            }
        }
    }

    GnuplotScript script() const {
        GnuplotScript body;
        body.line("unset border");
        body.line("unset tics");
        body.line("unset key");
        for (std::size_t kind = 0; kind < maps_.size(); ++kind) draw_map(body, kind);
        draw_legend(body);
        return body;
    }

  private:
    static std::string name_of(std::size_t kind, bool fires) {
        return (fires ? "$firing_" : "$silent_") + std::to_string(kind);
    }

    void draw_map(GnuplotScript& body, std::size_t kind) const {
        const Map& map = maps_[kind];
        const auto& [name, first, rows] = picture_.rows.kinds()[kind];
        const double begin = layout_.map_left(kind);
        const double top = layout_.map_top(kind);
        layout_.margins(body, begin, begin + layout_.box.width() * layout_.px_per_mm, top,
                        top + layout_.box.height() * layout_.px_per_mm);
        body.line("set xrange [", layout_.box.x_low, ':', layout_.box.x_high, ']');
        body.line("set yrange [", layout_.box.y_low, ':', layout_.box.y_high, ']');
        put_letter(body, kind, layout_.x(begin), layout_.y(top - 14));
        constexpr double after_letter = 24;
        body.line("set label ", gnuplot_text(name), " at screen ", layout_.x(begin + after_letter), ',',
                  layout_.y(top - 14), " left noenhanced font title_font textcolor rgb '",
                  colour_of_kind(picture_.rows.kinds(), kind), "'");
        body.line("set label ", gnuplot_text(with_thousands(map.afferents) + " afferents"), " at screen ",
                  layout_.x(begin + after_letter + 12 + 10 * static_cast<double>(name.size())), ',',
                  layout_.y(top - 14), " left noenhanced", axis_text);
        if (kind == 0) add_scale_bar(body, begin, top);
        body.line("plot $outline with filledcurves closed fs solid 1 noborder lc rgb '#FBF8F5' notitle, \\");
        body.line(
            "     $pressed using 1:2:3:3:4 with boxxyerror fs solid 1 noborder lc rgb variable notitle, \\");
        body.line("     $outline with lines lw 1 lc rgb '", colour::faint, "' notitle",
                  map.afferents > 0 ? ", \\" : "");
        if (map.afferents > 0) draw_marks(body, map, kind);
        body.line("unset label");
        body.line("unset arrow");
    }

    void draw_marks(GnuplotScript& body, const Map& map, std::size_t kind) const {
        const std::string silent = name_of(kind, false);
        const std::string firing = name_of(kind, true);
        if (map.square_mm > 0) {
            const double half = map.square_mm / 2;
            body.line("     ", silent, " using 1:2:(", half / 3, "):(", half / 3,
                      ") with boxxyerror fs solid 1 noborder lc rgb '", colour::faint, "' notitle, \\");
            body.line("     ", firing, " using 1:2:(", half, "):(", half,
                      "):3 with boxxyerror fs solid 1 noborder lc rgb variable notitle");
            return;
        }
        // A mark of size 1 is some 8 pixels wide; marks take half of the distance between neighbours.
        const double distance_px = layout_.px_per_mm * std::sqrt(layout_.box.width() * layout_.box.height() /
                                                                 static_cast<double>(map.marks.size()));
        const double size = std::clamp(distance_px / 14, 0.25, 1.3);
        const auto [filled, hollow] = kind_shapes[kind % kind_shapes.size()];
        body.line("     ", silent, " using 1:2 with points pt ", hollow, " ps ", 0.55 * size,
                  " lw 0.7 lc rgb '", colour::faint, "' notitle, \\");
        // A rim would hide the colour of a small mark.
        const bool rimmed = size > 0.6;
        body.line("     ", firing, " using 1:2:3 with points pt ", filled, " ps ", size,
                  " lc rgb variable notitle", rimmed ? ", \\" : "");
        if (rimmed)
            body.line("     ", firing, " using 1:2 with points pt ", hollow, " ps ", size, " lw 0.5 lc rgb '",
                      colour::axis, "' notitle");
    }

    void add_scale_bar(GnuplotScript& body, double begin, double top) const {
        const double bar_mm = round_below(layout_.box.width() / 3);
        const double y = layout_.y(top + layout_.box.height() * layout_.px_per_mm + 12);
        body.line("set arrow from screen ", layout_.x(begin), ',', y, " to screen ",
                  layout_.x(begin + bar_mm * layout_.px_per_mm), ',', y, " nohead lw 2 lc rgb '",
                  colour::axis, "'");
        body.line("set label '", short_number(bar_mm), " mm' at screen ",
                  layout_.x(begin + bar_mm * layout_.px_per_mm + 8), ',', y, " left", axis_text);
    }

    // The scale of colours, what is grey, and when that was.
    void draw_legend(GnuplotScript& body) const {
        constexpr double width = 18;
        constexpr double bar_height = 96;
        const double top = layout_.maps_top + map_title_px + 4;
        constexpr int steps = 48;
        for (int i = 0; i < steps; ++i) {
            const double from = top + bar_height * (1 - (i + 1.0) / steps);
            const double to = top + bar_height * (1 - static_cast<double>(i) / steps);
            body.line("set object rectangle from screen ", layout_.x(legend_px), ',', layout_.y(to),
                      " to screen ", layout_.x(legend_px + width), ',', layout_.y(from),
                      " fs solid 1 noborder fc rgb ", rate_colour((i + 0.5) / steps));
        }
        label(body, "Spike rate", legend_px, top - 16);
        for (const double share : {0.0, 0.5, 1.0})
            label(body, short_number(share * scale_hz_) + " Hz", legend_px + width + 8,
                  top + bar_height * (1 - share));
        double y = top + bar_height + 24;
        const bool squares = std::ranges::any_of(maps_, [](const Map& map) { return map.square_mm > 0; });
        if (squares) {
            label(body, "squares: mean of", legend_px, y);
            label(body, "their afferents", legend_px, y + 16);
            y += 36;
        } else {
            label(body, "hollow: silent", legend_px, y);
            y += 20;
        }
        label(body, "from " + short_number(picture_.from_s) + " to " + short_number(picture_.to_s) + " s,",
              legend_px, y);
        label(body, "its busiest span", legend_px, y + 16);
        y += 36;
        if (highest_kpa_ > 0) {
            body.line("set object rectangle from screen ", layout_.x(legend_px), ',', layout_.y(y + 6),
                      " to screen ", layout_.x(legend_px + 12), ',', layout_.y(y - 6),
                      " fs solid 1 noborder fc rgb '#969696'");
            label(body, short_number(highest_kpa_) + " kPa on the skin", legend_px + 18, y);
        }
        layout_.margins(body, 0, 1, 0, 1);
        body.line("set xrange [0:1]");
        body.line("set yrange [0:1]");
        body.line("plot NaN notitle");
        body.line("unset label");
        body.line("unset object");
    }

    void label(GnuplotScript& body, const std::string& text, double x, double y) const {
        body.line("set label ", gnuplot_text(text), " at screen ", layout_.x(x), ',', layout_.y(y),
                  " left noenhanced", axis_text);
    }

    const PopulationPicture& picture_;
    const PopulationLayout& layout_;
    std::vector<Map> maps_;
    double scale_hz_ = 1;
    double highest_kpa_ = 0;
};

}  // namespace

GnuplotScript population_maps(const PopulationPicture& picture, const PopulationLayout& layout,
                              std::string& data) {
    return Maps(picture, layout, data).script();
}

}  // namespace afferent
