// Question: which scheme needs the fewest bytes for the same error of the force, and where?
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "bench/touch.hpp"

namespace afferent {

struct MapCell {
    std::uint32_t elements;  // in patches of ten, or one
    double activity;         // which part of them is touched, in the mean
    // From the end of a packet's first scan to its use: the longest span, and delivery. It is that of news;
    // what came as foreseen may be told with the heartbeat, and the error has what the wait costs.
    Duration allowed_delay;
    double error_n;  // RMS while the object is held, that is allowed
    // The cheapest settings of each scheme that keep both; nothing where none does.
    struct Cost {
        std::string scheme;
        double bytes_per_s;
    };
    std::vector<Cost> costs;  // the cheapest first

    const Cost* cheapest() const noexcept { return costs.empty() ? nullptr : &costs.front(); }
};

// Events, in whichever code; the others are what may be sent instead.
bool is_of_events(const std::string& scheme);

// Each patch is touched by the force of a grasp, one after the other, again and again. Events may come from
// neurons that are tuned to fire less or more, and be predicted with a tolerance; samples may be rarer, and
// deltas larger. The error is that of a patch that is alone on its link: among others, what is foreseen would
// be told sooner. `progress` is told the fraction that is done.
std::vector<MapCell> map_schemes(const Scene& grasp, bool quick, const std::function<void(double)>& progress);

// map.csv. Throws std::runtime_error where it cannot be written.
void write_map(const std::vector<MapCell>& map, const std::filesystem::path& folder);
// map.svg and .png of one allowed error, where gnuplot is installed. Throws std::runtime_error where it
// fails.
void draw_map(const std::vector<MapCell>& map, double error_n, const std::filesystem::path& folder);
void print_map(const std::vector<MapCell>& map, std::ostream& out);

}  // namespace afferent
