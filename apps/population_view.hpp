// Collects what the picture of a population shows, as a run goes on.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "afferent/io/pictures/population_picture.hpp"
#include "afferent/runtime/scan.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// Memory grows with the addresses and elements, and with the events up to some hundred thousand.
class PopulationView {
  public:
    // The plan outlives it.
    explicit PopulationView(const Plan& plan);

    // Scans and events come in the order of time, each among its own.
    void scan(const Scan& scan) { pressure_.scan(scan); }
    void events(std::span<const Event> events);

    bool has_positions() const noexcept { return population_.has_positions(); }
    // Up to this time; <stem>.svg and <stem>.png.
    Drawing draw(TimePoint end, const std::filesystem::path& stem);

  private:
    void end_span();

    const Plan& plan_;
    Population population_;
    Skin skin_;
    PopulationRows rows_;
    Duration span_;
    PressureFrames pressure_;

    // The span that has come last, and the one with most spikes so far.
    struct Span {
        std::int64_t number = 0;
        std::uint64_t events = 0;
        std::vector<std::uint32_t> spikes;  // by address
    };
    Span current_;
    Span busiest_;

    std::uint64_t all_spikes_ = 0;
    std::vector<std::uint64_t> spikes_of_kind_;
    std::vector<Event> by_row_;
    std::optional<SpikeDensity> density_;
};

}  // namespace afferent
