#include "bench/decoding_cost.hpp"

#include <algorithm>
#include <array>
#include <iomanip>

#include "afferent/decoders/decoders.hpp"
#include "afferent/decoders/grip_decoder.hpp"
#include "bench/table_file.hpp"
#include "bench/thread_time.hpp"
#include "bench/touch.hpp"

namespace afferent {
namespace {

constexpr Duration span = 5ms;
constexpr Duration crowd_tick = 100us;
constexpr int passes = 5;

struct Crowd {
    DecodedAfferents afferents;
    std::vector<Event> events;
    Duration duration;
};

// Copies of a hand's afferents, each a little later than the one before: they share the force between them,
// and no two fire at the same instants.
Crowd copied(const TouchedForce& hand, std::uint32_t copies) {
    const auto addresses = static_cast<std::uint32_t>(hand.afferents.addresses);
    Crowd crowd{hand.afferents, {}, hand.activity.duration};
    crowd.afferents.tick = crowd_tick;
    crowd.afferents.addresses *= copies;
    crowd.afferents.afferents.clear();
    for (std::uint32_t copy = 0; copy < copies; ++copy) {
        for (const auto& [address, group, share, patch] : hand.afferents.afferents)
            crowd.afferents.afferents.push_back({copy * addresses + address, group, share / copies});
        const TimePoint later = scene_start + copy * Duration(span) / copies;
        for (const auto& [time, address] : hand.activity.events) {
            const Duration since_start = (time - scene_start) + (later - scene_start);
            crowd.events.push_back(
                {scene_start + since_start / crowd_tick * crowd_tick, copy * addresses + address});
        }
    }
    std::sort(crowd.events.begin(), crowd.events.end());
    return crowd;
}

struct Pass {
    double ns_per_event, ns_per_estimate;
};

Pass pass(const Crowd& crowd, const DecoderParameters& parameters) {
    const std::vector<Event>& events = crowd.events;
    GripDecoder decoder = make_decoder(parameters, crowd.afferents);
    double observing_s = 0;
    double estimating_s = 0;
    double estimates = 0;
    auto first = events.begin();
    for (TimePoint begin = scene_start; begin < scene_start + crowd.duration; begin += span) {
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

CostRow measured(const Crowd& crowd, const char* name, const DecoderParameters& parameters) {
    std::array<Pass, passes> took;
    for (Pass& each : took) each = pass(crowd, parameters);
    std::ranges::sort(took, {}, &Pass::ns_per_event);
    return {.afferents = static_cast<std::uint32_t>(crowd.afferents.afferents.size()),
            .decoder = name,
            .events_per_s = static_cast<double>(crowd.events.size()) / seconds(crowd.duration),
            .ns_per_event = took[passes / 2].ns_per_event,
            .least_ns = took.front().ns_per_event,
            .most_ns = took.back().ns_per_event,
            .ns_per_estimate = took[passes / 2].ns_per_estimate};
}

}  // namespace

std::vector<CostRow> measure_cost(const Scene& grasp, bool quick,
                                  const std::function<void(double)>& progress) {
    const TouchedForce hand = touched_force(grasp, 4s, grip_force_of(grasp));
    const std::vector<std::uint32_t> copies =
        quick ? std::vector<std::uint32_t>{1, 11} : std::vector<std::uint32_t>{1, 11, 1'111, 11'111};
    std::vector<CostRow> rows;
    for (const std::uint32_t count : copies) {
        const Crowd crowd = copied(hand, count);
        rows.push_back(measured(crowd, "sliding_window", SlidingWindowParameters()));
        rows.push_back(measured(crowd, "filter", FilterParameters()));
        progress(static_cast<double>(rows.size()) / static_cast<double>(2 * copies.size()));
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
