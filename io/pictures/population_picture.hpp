// The picture of a population: the skin from above with what presses it, its afferents by kind in the colours
// of their rates, and below all spikes by kind and place.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "afferent/io/pictures/gnuplot.hpp"
#include "afferent/io/pictures/population_rows.hpp"
#include "afferent/io/pictures/pressure_frames.hpp"
#include "afferent/io/pictures/spike_density.hpp"
#include "afferent/runtime/population.hpp"
#include "afferent/runtime/skin.hpp"

namespace afferent {

struct PopulationPicture {
    // Something that passes over the skin at a constant speed, along the direction of the rows.
    struct Passing {
        std::string name;
        double begin_mm;
        double speed_mm_per_s;
    };

    std::string title;  // may be empty
    double end_s = 0;   // of all spikes, from 0 on
    const Population& population;
    const Skin& skin;
    const PopulationRows& rows;
    std::string direction;  // along which rows are ordered, in words
    std::optional<Passing> passing = {};

    // The span in which the skin is seen, with the spikes of each address in it, and what presses the skin in
    // its middle.
    double from_s = 0;
    double to_s = 0;
    std::vector<std::uint32_t> spikes = {};
    std::vector<PressureFrames::Pressed> pressed = {};

    std::uint64_t all_spikes = 0;
    std::vector<std::uint64_t> spikes_of_kind = {};
    std::vector<Event> events = {};            // with rows in place of addresses
    std::optional<SpikeDensity> density = {};  // by row, instead of events, where there are too many
};

// Writes <stem>.svg and <stem>.png. Some afferent has a place.
Drawing draw(const PopulationPicture& picture, const std::filesystem::path& stem);

}  // namespace afferent
