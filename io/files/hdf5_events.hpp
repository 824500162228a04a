// What the two formats of events in HDF5 have in common. Only the sources of hdf5_files include this.
#pragma once

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "afferent/io/files/hdf5.hpp"
#include "afferent/io/files/hdf5_files.hpp"

namespace afferent::hdf5 {

// The message lacks the file's name, which the caller adds, as it does to errors of reading.
inline Error not_written() { return {Error::Kind::closed, "cannot be written"}; }

inline Result<void> check_set(const EventSet& set) {
    AFFERENT_TRY(check(set));
    const std::vector<Event>& events = set.events;
    if (events.empty()) return success();
    if (events.front().time >= scene_start && events.back().time < scene_start + longest_in_hdf5)
        return success();
    return Error{Error::Kind::not_allowed,
                 "HDF5 files hold nanoseconds for 26 days, and these events lie outside of them"};
}

// False: it is not a time, or later than any scene's end.
inline bool read_time(double value, double ns_per_unit, TimePoint& time) {
    constexpr double longest_ns = 4e18;
    const double ns = value * ns_per_unit;
    if (!(ns > -0.5 && ns < longest_ns)) return false;
    time = scene_start + Duration(std::llround(ns));
    return true;
}

// The resolution that a column of times states in an attribute, in the column's unit; 1 ns if there is none.
inline Duration resolution(hid_t column, double ns_per_unit) {
    const double ns = number_attribute(column, "resolution").value_or(0) * ns_per_unit;
    return ns >= 1 && ns < 1e18 ? Duration(std::llround(ns)) : Duration(1);
}

// What the columns of a table tell of its afferents; nothing where one is missing, or not of that many rows.
struct PlaceColumns {
    const char* x;
    const char* y;
    double units_per_mm = 1;
};
inline std::vector<Population::Afferent> read_afferents(hid_t table, const PlaceColumns& place,
                                                        std::size_t rows) {
    const auto element = read_whole_numbers(table, "element");
    const auto elements = read_whole_numbers(table, "elements");
    if (!element || !elements || element.value().size() != rows || elements.value().size() != rows) return {};
    const auto x = read_numbers(table, place.x);
    const auto y = read_numbers(table, place.y);
    const bool has_positions = x && y && x.value().size() == rows && y.value().size() == rows;
    std::vector<Population::Afferent> afferents(rows);
    for (std::size_t row = 0; row < rows; ++row) {
        afferents[row].element = static_cast<Address>(element.value()[row]);
        afferents[row].elements = static_cast<std::uint32_t>(elements.value()[row]);
        if (!has_positions || !std::isfinite(x.value()[row]) || !std::isfinite(y.value()[row])) continue;
        afferents[row].place = {x.value()[row] / place.units_per_mm, y.value()[row] / place.units_per_mm};
    }
    return afferents;
}

inline bool is_address(std::uint64_t number) { return number <= std::numeric_limits<Address>::max(); }

}  // namespace afferent::hdf5
