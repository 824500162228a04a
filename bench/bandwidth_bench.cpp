#include "bench/bandwidth_bench.hpp"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <utility>
#include <variant>

#include "afferent/io/files/table.hpp"
#include "afferent/io/wire/packet_layout.hpp"
#include "afferent/scene/plan.hpp"
#include "afferent/scene/scene.hpp"
#include "bench/decoding_bench.hpp"

namespace afferent {
namespace {

constexpr double poisson_hz = 20;

GripForce force_of(const Table& table) {
    return [&table](TimePoint time) {
        const auto after = std::upper_bound(table.times.begin(), table.times.end(), time);
        if (after == table.times.begin()) return 0.0;
        return std::max(0.0, table.row(static_cast<std::size_t>(after - table.times.begin()) - 1)[0]);
    };
}

}  // namespace

std::vector<LinkActivity> link_activities(const BandwidthScenes& scenes) {
    const Scene scene = Scene::from_file(scenes.scene);
    const std::uint32_t own_elements = make_plan(scene).elements;
    const GripForce force = grip_force_of(scene);
    std::optional<LinkActivity> recorded = recorded_activity(scene);
    const std::string touch = recorded ? recorded->name : "grasp";
    std::vector<LinkActivity> found;
    for (const std::uint32_t elements : scenes.elements) {
        std::cerr << elements << " elements\n";
        const Duration duration = scene.end() - scene_start;
        found.push_back(grip_activity(scene, elements, "rest", std::min<Duration>(duration, 2s),
                                      [](TimePoint) { return 0; }));
        found.push_back(poisson_activity(elements, poisson_hz,
                                         elements < 100      ? 100s
                                         : elements < 10'000 ? 10s
                                                             : 1s,
                                         1));
        // On its own elements the recorded samples are sent as they are; on other numbers of elements,
        // samples of its grip force.
        if (recorded && elements == own_elements)
            found.push_back(*recorded);
        else
            found.push_back(grip_activity(scene, elements, touch, duration, force));
    }
    for (const std::string& file : scenes.force_tables) {
        auto read = read_table(file);
        if (const auto* error = std::get_if<TableError>(&read)) throw std::runtime_error(error->message());
        const Table& table = std::get<Table>(read);
        found.push_back(grip_activity(scene, own_elements, std::filesystem::path(file).stem().string(),
                                      table.times.back() - scene_start, force_of(table)));
    }
    return found;
}

void measure_force_errors(const LinkActivity& activity, std::vector<SchemeResult>& results) {
    if (!activity.grip || activity.elements > 10'000) return;
    const auto& [scene, force_n] = *activity.grip;
    const Touch touch(activity.name, {touched_force(scene, activity.duration, force_n)});
    if (touch.touched() == 0) return;
    // The error depends on what is sent and when, not on how it is coded: it is computed once for each
    // setting.
    std::vector<std::pair<DecodingCell, double>> found;
    for (SchemeResult& result : results) {
        DecodingCell cell{.scheme = "raw12",
                          .decoder = "force_model",
                          .deadline = result.deadline.value_or(activity.frame_interval)};
        if (result.tick) cell = {"events", "filter", result.tick, cell.deadline};
        if (result.tolerance.value_or(0ns) > 0ns) {
            cell.scheme = "predicted";
            cell.tolerance = result.tolerance;
        }
        if (result.delta_n) {
            cell.scheme = result.scheme;
            cell.delta = *result.delta_n / activity.newtons_per_count / 4095;
            cell.dead_band = result.dead_band;
        }
        auto at = std::find_if(found.begin(), found.end(),
                               [&](const auto& measured) { return measured.first == cell; });
        if (at == found.end()) at = found.insert(at, {cell, score(follow(touch, cell), Touch::step).rms_n});
        result.rms_n = at->second;
    }
}

std::vector<SchemeResult> measure_schemes(const LinkActivity& activity) {
    std::vector<SchemeResult> results;
    const auto poisson = activity.name == "poisson20" ? std::optional(poisson_hz) : std::nullopt;
    for (const Duration tick : {Duration(1us), Duration(100us), Duration(1ms)})
        for (const Duration deadline : {Duration(1ms), Duration(5ms), Duration(10ms), Duration(20ms)}) {
            const PacketLayout layout{.addresses = activity.addresses, .tick = tick, .span = deadline};
            if (layout.codes() <= std::uint64_t{1} << 32)
                results.push_back(measure_events(activity, tick, deadline, poisson));
        }
    for (const Duration tolerance : {Duration(0us), Duration(200us), Duration(500us), Duration(1ms)})
        if (const auto predicted = measure_predicted(activity, 100us, 5ms, tolerance))
            results.push_back(*predicted);
    results.push_back(measure_repeated_messages(activity, 100us, 5ms));
    results.push_back(measure_packed_columns(activity, 100us, 5ms));
    if (activity.counts.empty()) return results;
    results.push_back(measure_raw(activity, 12));
    results.push_back(measure_raw(activity, 16));
    results.push_back(measure_delta_varint(activity));
    results.push_back(measure_delta_coded(activity));
    // Deltas as shares of one element's full scale, which is a share of the grip force.
    for (const auto measure : {measure_send_on_delta, measure_linear_prediction})
        for (const double of_scale : {0.002, 0.01, 0.05})
            results.push_back(measure(activity, of_scale * 4095 * activity.newtons_per_count));
    for (const double fraction : {0.05, 0.1})
        results.push_back(measure_dead_band(activity, fraction, 0.01 * 4095 * activity.newtons_per_count));
    return results;
}

Bandwidth measure_bandwidth(const std::vector<LinkActivity>& activities,
                            const std::function<void(double)>& progress) {
    Bandwidth bandwidth;
    for (const LinkActivity& activity : activities) {
        progress(static_cast<double>(&activity - activities.data()) /
                 static_cast<double>(activities.size() + 1));
        std::vector<SchemeResult> results = measure_schemes(activity);
        measure_force_errors(activity, results);
        for (SchemeResult& result : results) bandwidth.rows.push_back({&activity, std::move(result)});
    }
    bandwidth.transports = measure_transports({1ms, 5ms, 20ms});
    return bandwidth;
}

}  // namespace afferent
