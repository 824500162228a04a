#include "afferent/io/pictures/movie.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <limits>

#include "afferent/io/pictures/gnuplot_script.hpp"
#include "afferent/io/pictures/movie_template.hpp"
#include "afferent/io/pictures/rate_colours.hpp"

namespace afferent {
namespace {

// Text between quotes in a script within a page: neither the string nor the script can be ended by it.
std::string script_text(std::string_view text) {
    std::string quoted = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\' || c == '<' || c == '&' || static_cast<unsigned char>(c) < 0x20) {
            std::array<char, 8> code{};
            std::snprintf(code.data(), code.size(), "\\u%04x",
                          static_cast<unsigned>(static_cast<unsigned char>(c)));
            quoted += code.data();
        } else {
            quoted += c;
        }
    }
    return quoted + '"';
}

// Little-endian numbers, in base 64.
class Numbers {
  public:
    void u8(std::uint8_t value) { bytes_.push_back(value); }
    void u32(std::uint32_t value) {
        for (int shift = 0; shift < 32; shift += 8)
            bytes_.push_back(static_cast<std::uint8_t>(value >> shift));
    }
    void f32(double value) { u32(std::bit_cast<std::uint32_t>(static_cast<float>(value))); }

    std::string text() const {
        static constexpr std::string_view digits =
            "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        std::string text;
        text.reserve(bytes_.size() * 4 / 3 + 8);
        text += '"';
        for (std::size_t i = 0; i < bytes_.size(); i += 3) {
            std::uint32_t three = 0;
            for (std::size_t j = 0; j < 3; ++j)
                three = three << 8U | (i + j < bytes_.size() ? bytes_[i + j] : 0U);
            for (std::size_t j = 0; j < 4; ++j)
                text += i + j <= bytes_.size() ? digits[three >> (18 - 6 * j) & 63U] : '=';
        }
        return text + '"';
    }

  private:
    std::vector<std::uint8_t> bytes_;
};

// The members of an object, `"name":value`.
class Members {
  public:
    void add(std::string_view name, const std::string& value) {
        text_ += (text_.empty() ? "" : ",\n") + ('"' + std::string(name) + "\":") + value;
    }
    void add(std::string_view name, double value) { add(name, gnuplot_number(value)); }
    std::string object() const { return '{' + text_ + '}'; }

  private:
    std::string text_;
};

template <class Range, class Text>
std::string list_of(const Range& range, Text text) {
    std::string list(1, '[');
    for (const auto& each : range) {
        if (list.size() > 1) list += ',';
        list += text(each);
    }
    list += ']';
    return list;
}

void add_population(Members& members, const Movie& movie) {
    const auto& kinds = movie.rows.kinds();
    std::size_t index = 0;
    members.add("kinds", list_of(kinds, [&](const PopulationRows::Kind& kind) {
                    Members of_kind;
                    of_kind.add("name", script_text(kind.name));
                    of_kind.add("colour", script_text(colour_of_kind(kinds, index++)));
                    of_kind.add("first", kind.first);
                    of_kind.add("rows", kind.rows);
                    return of_kind.object();
                }));
    Numbers places;
    Numbers kind_of;
    Numbers row_of;
    for (Address address = 0; address < movie.population.afferents.size(); ++address) {
        const auto& place = movie.population.afferents[address].place;
        places.f32(place ? place->x_mm : std::numeric_limits<double>::quiet_NaN());
        places.f32(place ? place->y_mm : std::numeric_limits<double>::quiet_NaN());
        kind_of.u8(static_cast<std::uint8_t>(movie.rows.kind(address)));
        row_of.u32(movie.rows.row(address));
    }
    members.add("places", places.text());
    members.add("kindOf", kind_of.text());
    members.add("rowOf", row_of.text());
    members.add("outlines", list_of(movie.skin.outlines, [](const std::vector<Position>& outline) {
                    return list_of(outline, [](const Position& corner) {
                        return '[' + gnuplot_number(corner.x_mm) + ',' + gnuplot_number(corner.y_mm) + ']';
                    });
                }));
}

void add_events(Members& members, const Movie& movie) {
    Numbers times;
    Numbers addresses;
    for (const Event& event : movie.events) {
        times.u32(static_cast<std::uint32_t>((event.time - movie.begin) / Duration(1us)));
        addresses.u32(event.address);
    }
    members.add("times", times.text());
    members.add("addresses", addresses.text());
}

// Pressures as shares of the highest, in 255 steps; of the elements that are pressed at some time.
void add_pressure(Members& members, const Movie& movie) {
    if (!movie.pressure) return;
    const auto kpa = [&](const PressureFrames::Pressed& each) {
        return movie.skin.elements[each.element].pressure_kpa(each.force_n);
    };
    const auto& frames = movie.pressure->frames();
    double highest = 0;
    for (const auto& frame : frames)
        for (const auto& each : frame) highest = std::max(highest, kpa(each));
    Numbers cells;
    Numbers ends;
    Numbers pressed;
    Numbers levels;
    std::vector<std::uint32_t> cell_of(movie.skin.elements.size());  // counted from 1; 0: none yet
    std::uint32_t count = 0;
    std::uint32_t end = 0;
    for (const auto& frame : frames) {
        for (const auto& each : frame) {
            if (kpa(each) <= 0) continue;
            std::uint32_t& cell = cell_of[each.element];
            if (cell == 0) {
                cell = ++count;
                const auto& [place, width_mm] = movie.skin.elements[each.element];
                cells.f32(place.x_mm);
                cells.f32(place.y_mm);
                cells.f32(width_mm);
            }
            pressed.u32(cell - 1);
            levels.u8(static_cast<std::uint8_t>(std::lround(255 * kpa(each) / highest)));
            ++end;
        }
        ends.u32(end);
    }
    Members pressure;
    pressure.add("interval_s", seconds(scene_start + movie.pressure_interval));
    pressure.add("highest_kpa", highest);
    pressure.add("cells", cells.text());
    pressure.add("ends", ends.text());
    pressure.add("pressed", pressed.text());
    pressure.add("levels", levels.text());
    members.add("pressure", pressure.object());
}

}  // namespace

std::uint64_t movie_bytes(std::uint64_t afferents, std::uint64_t events) {
    constexpr std::uint64_t bytes_of_afferent = 2 * 4 + 1 + 4;
    constexpr std::uint64_t bytes_of_event = 4 + 4;
    return movie_template.size() + (afferents * bytes_of_afferent + events * bytes_of_event) * 4 / 3;
}

std::string movie_page(const Movie& movie) {
    Members members;
    members.add("title", script_text(movie.title));
    members.add("direction", script_text(movie.direction));
    members.add("begin_s", seconds(movie.begin));
    members.add("end_s", seconds(movie.end));
    members.add("rateStops", list_of(rate_stops, [](const auto& stop) {
                    return list_of(stop, [](double part) { return gnuplot_number(part); });
                }));
    add_population(members, movie);
    add_events(members, movie);
    add_pressure(members, movie);
    std::string page(movie_template);
    constexpr std::string_view place = "{/*data*/}";
    page.replace(page.find(place), place.size(), members.object());
    return page;
}

}  // namespace afferent
