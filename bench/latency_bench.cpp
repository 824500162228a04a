#include "bench/latency_bench.hpp"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <vector>

#include "afferent/engine/coprocessor.hpp"
#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/packetizer.hpp"
#include "afferent/nodes/run.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent::bench {
namespace {

using Clock = std::chrono::steady_clock;

struct Recording {
    struct Sampled {
        TimePoint time;
        Address first;
        std::vector<double> forces_n;
    };
    std::vector<Sampled> scans;
    std::vector<Event> events;
};

Recording record(const Plan& plan) {
    Recording recording;
    Observer output;
    output.events = [&](std::span<const Event> events) {
        recording.events.insert(recording.events.end(), events.begin(), events.end());
    };
    output.scan = [&](const Scan& scan) {
        recording.scans.push_back({scan.time, scan.first, {scan.forces_n.begin(), scan.forces_n.end()}});
    };
    auto run = Run::open(plan, std::move(output));
    if (!run) throw std::runtime_error(run.error().text);
    while (!run.value()->done())
        if (const Result<void> stepped = run.value()->do_next(); !stepped)
            throw std::runtime_error(stepped.error().text);
    return recording;
}

Latency summarise(std::vector<double> us) {
    if (us.empty()) return {};
    std::sort(us.begin(), us.end());
    return {us[us.size() / 2], us[us.size() * 99 / 100], us.back()};
}

double to_us(Clock::duration duration) { return std::chrono::duration<double, std::micro>(duration).count(); }

}  // namespace

LatencyResult run_latency_bench(const Scene& scene, int repetitions) {
    const Plan plan = make_plan(scene);
    const Recording recording = record(plan);
    const Duration span = plan.timing.span;
    std::vector<double> all_us;
    std::vector<double> with_spikes_us;
    std::vector<Event> events;
    std::uint64_t bytes = 0;
    for (int repetition = 0; repetition < repetitions; ++repetition) {
        Coprocessor coprocessor(plan);
        Packetizer packetizer(packet_layout(plan));
        FrameWriter writer;
        events.clear();
        auto scan = recording.scans.begin();
        for (TimePoint deadline = scene_start + span; deadline <= plan.end(); deadline += span) {
            const auto begin = Clock::now();
            for (; scan != recording.scans.end() && scan->time < deadline; ++scan)
                coprocessor.push({scan->time, scan->first, scan->forces_n});
            const auto spikes = coprocessor.advance(deadline - Duration(1));
            packetizer.push(spikes);
            packetizer.close(deadline,
                             [&](const auto& packet) { bytes += writer.stream_frame(packet).size(); });
            const double us = to_us(Clock::now() - begin);
            all_us.push_back(us);
            if (!spikes.empty()) with_spikes_us.push_back(us);
            events.insert(events.end(), spikes.begin(), spikes.end());
        }
        if (repetition == 0 && (events != recording.events || bytes == 0))
            throw std::runtime_error("the events are not those of the run");
    }
    const auto begin = Clock::now();
    for (int i = 0; i < 1000; ++i) (void)Clock::now();
    const double clock_us = to_us(Clock::now() - begin) / 1000;
    const std::size_t spans = all_us.size();
    return {spans, summarise(std::move(all_us)), summarise(std::move(with_spikes_us)), clock_us};
}

}  // namespace afferent::bench
