// What a run or a replay gives, kept in memory as rows of plain numbers, for programs that look at it
// afterwards.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>
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

// The columns of a kind of read-out in memory: a time is 8 bytes of nanoseconds, a patch or a count 4 bytes,
// and a number a double.
struct KeptColumn {
    const char* name;
    const char* format;  // as NumPy writes it
    std::size_t offset;
};
std::vector<KeptColumn> kept_columns(const PatchReadout& kind);
std::size_t kept_row_bytes(const PatchReadout& kind);

struct KeptResults {
    std::vector<Event> events;
    std::vector<KeptStep> steps;
    std::vector<KeptPart> parts;  // of each step, in the order of the plan's parts
    std::array<std::vector<std::byte>, std::variant_size_v<PatchReadout>> readouts;  // rows of each kind
    DoubtTimes doubts;                                                               // of the steps

    // So many rows are to come.
    void expect_steps(std::size_t steps, std::size_t parts_of_each);
    void add(std::span<const Event> new_events) {
        events.insert(events.end(), new_events.begin(), new_events.end());
    }
    void add(const ControllerStep& step);
};

}  // namespace afferent
