// What a run or a replay gives, kept in memory as rows of plain numbers, for programs that look at it
// afterwards.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "afferent/engine/controller.hpp"
#include "afferent/nodes/doubt_times.hpp"
#include "afferent/runtime/event.hpp"

namespace afferent {

// The rows have a fixed layout, so that other languages can read them in place. A number that is not known is
// NaN.
// The name of a Doubt, in characters that other languages take for text; zeros follow.
using KeptDoubt = std::array<char32_t, 12>;

struct KeptStep {
    std::int64_t time_ns;
    double true_force_n;
    double estimate_n;
    double sigma_n;
    double rate_hz;
    double gain;
    double closing_counts;
    double closing_effort;
    double opening_effort;
    double command;
    KeptDoubt doubt;
};

struct KeptPart {
    double true_force_n;
    double estimate_n;
    double sigma_n;
    KeptDoubt doubt;
};

struct KeptContact {
    std::int64_t time_ns;
    std::uint32_t patch;
    std::uint32_t afferents;
    double force_n, force_sigma_n;
    double x_mm, x_sigma_mm;
    double y_mm, y_sigma_mm;
    double area_mm2, area_sigma_mm2;
};

struct KeptTouch {
    std::int64_t begin_ns;
    std::int64_t told_ns;
    std::uint32_t patch;
    std::uint32_t afferents;
    bool slides;
    double orientation_deg, sigma_deg;
    // NaN where it does not slide.
    double direction_deg;
    double speed_mm_per_s, speed_sigma_mm_per_s;
};

struct KeptResults {
    std::vector<Event> events;
    std::vector<KeptStep> steps;
    std::vector<KeptPart> parts;  // of each step, in the order of the plan's parts
    std::vector<KeptContact> contacts;
    std::vector<KeptTouch> touches;
    DoubtTimes doubts;  // of the steps

    // So many rows are to come.
    void expect_steps(std::size_t steps, std::size_t parts_of_each);
    void add(std::span<const Event> new_events) {
        events.insert(events.end(), new_events.begin(), new_events.end());
    }
    void add(const ControllerStep& step);
};

}  // namespace afferent
