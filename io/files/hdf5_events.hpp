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

inline bool is_address(std::uint64_t number) { return number <= std::numeric_limits<Address>::max(); }

}  // namespace afferent::hdf5
