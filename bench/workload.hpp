// What a benchmark gives to a solver, and what it gets back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "afferent/neurons/parameters.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent::bench {

// Neurons and their drives, each held until the next row. The first row is at scene_start.
struct Workload {
    std::string name;
    std::vector<LifParameters> parameters;  // one for all, or one for each
    std::size_t neurons = 1;
    std::vector<TimePoint> times;
    std::vector<double> drives_mv;  // row by row
    TimePoint until;
    std::size_t max_spikes = std::numeric_limits<std::size_t>::max();  // of a neuron, which then stops
    double most_steps = 2e8;  // of all neurons together: a stepping solver that needs more may give up

    std::size_t rows() const noexcept { return times.size(); }
    std::span<const double> row(std::size_t i) const noexcept {
        return std::span(drives_mv).subspan(i * neurons, neurons);
    }
    double drive_mv(std::size_t row, std::size_t neuron) const noexcept {
        return drives_mv[row * neurons + neuron];
    }
    TimePoint end(std::size_t row) const noexcept { return row + 1 < rows() ? times[row + 1] : until; }
    const LifParameters& of(std::size_t neuron) const noexcept {
        return parameters.size() == 1 ? parameters.front() : parameters[neuron];
    }
    // The longest interval that divides the time of every row, and of the end.
    Duration common_interval() const noexcept {
        Duration::rep common = (until - scene_start).count();
        for (const TimePoint time : times) common = std::gcd(common, (time - scene_start).count());
        return Duration(common);
    }
};

// A spike time without rounding: as exact an hour into the run as in its first second.
struct SpikeTime {
    TimePoint near;
    Interval rest;

    friend Interval operator-(const SpikeTime& a, const SpikeTime& b) noexcept {
        return Interval(static_cast<double>((a.near - b.near).count())) + (a.rest - b.rest);
    }
};

using Train = std::vector<SpikeTime>;
using Trains = std::vector<Train>;  // one for each neuron

}  // namespace afferent::bench
