#include "bench/decoding_cost.hpp"

#include <algorithm>
#include <array>
#include <iomanip>

#include "afferent/decoders/decoders.hpp"
#include "bench/table_file.hpp"
#include "bench/thread_time.hpp"
#include "bench/touch.hpp"

namespace afferent {
namespace {

constexpr Duration span = 5ms;
constexpr Duration tick = 100us;
constexpr int passes = 5;
// The window computes a curve for each afferent that differs, before it begins.
constexpr std::uint32_t most_counted = 100;

struct Pass {
    double ns_per_event, ns_per_estimate;
};

Pass pass(const TouchedForce& force, const std::vector<Event>& events, const DecoderParameters& parameters) {
    DecodedAfferents afferents = force.afferents;
    afferents.tick = tick;
    GripDecoder decoder = make_decoder(parameters, afferents);
    double observing_s = 0;
    double estimating_s = 0;
    double estimates = 0;
    auto first = events.begin();
    for (TimePoint begin = scene_start; begin < scene_start + force.activity.duration; begin += span) {
        const auto last = std::partition_point(first, events.end(),
                                               [&](const Event& event) { return event.time < begin + span; });
        const double start_s = bench::thread_seconds();
        decoder.observe(begin, begin + span, {first, last});
        const double observed_s = bench::thread_seconds();
        decoder.estimate(begin + span);
        estimating_s += bench::thread_seconds() - observed_s;
        observing_s += observed_s - start_s;
        ++estimates;
        first = last;
    }
    return {1e9 * observing_s / static_cast<double>(events.size()), 1e9 * estimating_s / estimates};
}

CostRow measured(const TouchedForce& force, const std::vector<Event>& events, const char* name,
                 const DecoderParameters& parameters) {
    std::array<Pass, passes> took;
    for (Pass& each : took) each = pass(force, events, parameters);
    std::ranges::sort(took, {}, &Pass::ns_per_event);
    return {.afferents = static_cast<std::uint32_t>(force.afferents.afferents.size()),
            .decoder = name,
            .events_per_s = static_cast<double>(events.size()) / force.activity.seconds_long(),
            .ns_per_event = took[passes / 2].ns_per_event,
            .least_ns = took.front().ns_per_event,
            .most_ns = took.back().ns_per_event,
            .ns_per_estimate = took[passes / 2].ns_per_estimate};
}

}  // namespace

std::vector<CostRow> measure_cost(const Scene& grasp, bool quick,
                                  const std::function<void(double)>& progress) {
    const std::vector<std::uint32_t> sizes =
        quick ? std::vector<std::uint32_t>{9, 100} : std::vector<std::uint32_t>{9, 100, 1'000};
    std::vector<CostRow> rows;
    std::size_t done = 0;
    for (const std::uint32_t size : sizes) {
        const TouchedForce force = touched_force(scaled_scene(grasp, size), 4s, grip_force_of(grasp));
        std::vector<Event> events = force.activity.events;
        for (Event& event : events) event.time -= (event.time - scene_start) % tick;
        std::sort(events.begin(), events.end());
        if (size <= most_counted)
            rows.push_back(measured(force, events, "sliding_window", SlidingWindow::Parameters()));
        rows.push_back(measured(force, events, "filter", Filter::Parameters()));
        progress(static_cast<double>(++done) / static_cast<double>(sizes.size()));
    }
    return rows;
}

void write_cost(const std::vector<CostRow>& rows, const std::filesystem::path& folder) {
    bench::TableFile file(folder / "cost.csv", {"afferents", "decoder", "events_per_s", "ns_per_event",
                                                "least_ns", "most_ns", "ns_per_estimate", "core"});
    for (const CostRow& row : rows)
        file.row({std::to_string(row.afferents), row.decoder, bench::number(row.events_per_s),
                  bench::number(row.ns_per_event), bench::number(row.least_ns), bench::number(row.most_ns),
                  bench::number(row.ns_per_estimate), bench::number(row.core())});
    file.close();
}

void print_cost(const std::vector<CostRow>& rows, std::ostream& out) {
    out << "\nWhat an event takes, ns of one thread (least to most), and the part of one core in real time\n"
        << std::setprecision(3);
    for (const CostRow& row : rows)
        out << "  " << std::setw(7) << row.afferents << ' ' << std::left << std::setw(15) << row.decoder
            << std::right << std::setw(8) << row.ns_per_event << " (" << row.least_ns << " to " << row.most_ns
            << ")  " << 100 * row.core() << " %\n";
}

}  // namespace afferent
