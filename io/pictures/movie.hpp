// A population in motion: the skin from above and its spikes, as one page for a browser, which needs no
// network and no other file.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "afferent/io/pictures/population_rows.hpp"
#include "afferent/io/pictures/pressure_frames.hpp"
#include "afferent/runtime/population.hpp"
#include "afferent/runtime/skin.hpp"

namespace afferent {

struct Movie {
    std::string title;
    std::string direction;  // along which rows are ordered, in words
    const Population& population;
    const Skin& skin;  // without outlines where nobody knows them
    const PopulationRows& rows;

    // The time that is shown, and its events in their order. Times are kept to the microsecond.
    TimePoint begin;
    TimePoint end;
    std::span<const Event> events;

    // From `begin` on; null: nobody knows what pressed the skin.
    const PressureFrames* pressure = nullptr;
    Duration pressure_interval = {};
};

// The longest time that microseconds in 32 bits can tell.
inline constexpr Duration longest_movie = std::chrono::seconds(4200);

// The bytes that afferents and events take in the page, and one pressed element in one frame.
std::uint64_t movie_bytes(std::uint64_t afferents, std::uint64_t events);
inline constexpr std::uint64_t movie_bytes_of_pressed = 7;

// The page. Not longer than longest_movie; some afferent has a place.
std::string movie_page(const Movie& movie);

}  // namespace afferent
