// Question: what does a population cost by its size, by how much of it is touched, by the form in which it is
// carried out, and by threads?
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/scale_population.hpp"

namespace afferent::bench {

// A run's cost: the median of repeats that take turns with those of the runs that it is compared with. On one
// thread the time is the thread's own, so that what others make it wait does not count; on several it is the
// wall clock's, and so is least_wall_s always.
struct ScaleCost {
    double frame_s = 0;
    double least_s = 0, most_s = 0;
    double least_wall_s = 0;
    double cpu_s = 0;  // of all threads
    double events_per_frame = 0;
    std::optional<double> joules_per_event = {};
    std::size_t bytes = 0;  // Coprocessor::bytes()

    double realtime_factor() const noexcept { return seconds(scale_frame) / frame_s; }
    double ns_per_element_frame(std::uint32_t elements) const noexcept { return 1e9 * frame_s / elements; }
    // Per second of run time.
    double events_per_s() const noexcept { return events_per_frame / frame_s; }
};

struct ScaleRow {
    ScaleRun run;
    ScaleCost cost;
    std::uint32_t ranks = 1;

    double ns() const noexcept { return cost.ns_per_element_frame(run.population.elements); }
    double bytes_per_element() const noexcept {
        return static_cast<double>(cost.bytes) / run.population.elements;
    }
};

// How thoroughly.
struct ScaleEffort {
    std::uint64_t settling_frames = 40;  // until the adaptation is in its steady state, nearly
    std::size_t repeats = 5;
    double repeat_s = 0.03;

    static ScaleEffort quick() { return {20, 3, 0.01}; }
};

// Settles all of them, and compares their events on the way: bit for bit between those that differ in
// threads only, within 1 ns between forms. Then takes their time, in turns. Runs of one population only, or
// of several, which are then compared within each. Throws std::runtime_error where events differ.
std::vector<ScaleCost> measure_together(const std::vector<ScaleRun>& runs, const ScaleEffort& effort);

// Throws std::runtime_error, which names the first afferent that differs, unless these are the same events
// with stamps within 1 ns. What comes within 1 ns of `end` may be missing on one side. Sorts both by address.
void require_same_events(std::vector<Event>& these, std::vector<Event>& those, TimePoint end,
                         const std::string& names);

// At which fraction of touched elements the sweep takes over from prediction, on one thread.
struct ScaleCrossing {
    std::uint32_t elements;
    std::optional<double> fraction;  // none: one form is the cheaper throughout
    bool sparse_when_idle;
};

struct ScaleOptions {
    std::vector<std::uint32_t> elements = {9, 100, 1000, 10'000, 100'000, 1'000'000};
    bool quick = false;

    ScaleEffort effort() const { return quick ? ScaleEffort::quick() : ScaleEffort(); }
};

// 1, 2, 4, ... and as many as the machine has.
std::vector<std::uint32_t> scale_threads();

// All sizes, idle to fully touched, in every form; threads where there is work for them. `progress` is told
// the fraction that is done.
std::vector<ScaleRow> measure_scale(const ScaleOptions& options, const std::function<void(double)>& progress);

std::vector<ScaleCrossing> crossings(const std::vector<ScaleRow>& rows);

}  // namespace afferent::bench
