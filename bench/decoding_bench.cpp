#include "bench/decoding_bench.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <random>
#include <thread>
#include <utility>

#include "afferent/runtime/parallel.hpp"
#include "bench/link_schemes.hpp"
#include "bench/sample_coding.hpp"
#include "bench/sampled_force.hpp"
#include "bench/wander_limits.hpp"

namespace afferent {
namespace {

const DecoderParameters& decoder_named(const std::string& name) {
    return std::find_if(named_decoders().begin(), named_decoders().end(),
                        [&](const NamedDecoder& decoder) { return decoder.name == name; })
        ->parameters;
}

std::uint32_t scans_per_packet(const LinkActivity& activity, const DecodingCell& cell) {
    const Duration interval = cell.every_scan * activity.frame_interval;
    return static_cast<std::uint32_t>(std::max<Duration::rep>(1, cell.deadline / interval));
}

// The payloads of the packets with samples: each has the scans of its span.
std::vector<std::string> sample_payloads(const LinkActivity& activity, const DecodingCell& cell) {
    const std::uint32_t batch = scans_per_packet(activity, cell);
    const std::size_t sent_scans = activity.scans() / cell.every_scan;
    std::vector<std::string> payloads;
    std::vector<std::uint16_t> counts;
    std::vector<std::uint16_t> before(activity.elements, 0);
    std::vector<CountChange> changes;
    SendOnDelta sender(activity.elements,
                       std::max(1, static_cast<int>(std::lround(cell.delta.value_or(0) * 4095))));
    for (std::size_t first = 0; first + batch <= sent_scans; first += batch) {
        std::string& payload = payloads.emplace_back();
        counts.clear();
        changes.clear();
        for (std::uint32_t i = 0; i < batch; ++i) {
            const Counts scan = activity.scan((first + i) * cell.every_scan);
            if (cell.scheme == "delta_varint") {
                encode_differences(scan, before, payload);
                before.assign(scan.begin(), scan.end());
            }
            // A batch is taken for one scan of so many more elements.
            if (cell.delta) sender.send(scan, i * activity.elements, changes);
            if (cell.scheme == "raw12") counts.insert(counts.end(), scan.begin(), scan.end());
        }
        encode_raw(counts, 12, payload);
        encode_changes(changes, payload);
    }
    return payloads;
}

std::vector<Estimate> follow_samples(const TouchedForce& force, const DecodingCell& cell) {
    const LinkActivity& activity = force.activity;
    const std::uint32_t batch = scans_per_packet(activity, cell);
    const Duration interval = cell.every_scan * activity.frame_interval;
    const bool held = cell.decoder == "hold";
    const double scale = activity.newtons_per_count;
    SendOnDelta sender(activity.elements,
                       std::max(1, static_cast<int>(std::lround(cell.delta.value_or(0) * 4095))));
    SampledForce model(force);
    std::vector<CountChange> changes;
    std::vector<int> moved(activity.elements);
    std::vector<Estimate> estimates;
    double held_n = 0;
    double share = 0;
    for (const double each : force.share) share += each;
    std::size_t next = 0;  // scan that is sent
    for (std::size_t k = 0; k < force.true_n.size(); ++k) {
        const TimePoint now = scene_start + static_cast<Duration::rep>(k) * Touch::step;
        // With the last scan of its packet each has been sent.
        for (;; ++next) {
            const auto closes = static_cast<Duration::rep>(next - next % batch + batch - 1);
            const std::size_t scan = next * cell.every_scan;
            if (scan >= activity.scans() || scene_start + closes * interval + delivery > now) break;
            const double time_s = seconds(interval) * static_cast<double>(next);
            const Counts counts = activity.scan(scan);
            double sum = 0;
            if (cell.delta) {
                changes.clear();
                sender.send(counts, 0, changes);
                std::fill(moved.begin(), moved.end(), 0);
                for (const CountChange& change : changes) moved[change.element] = change.deltas;
                for (const int sent : sender.sent()) sum += sent;
                if (!held) model.read_changes(time_s, sender.step(), sender.sent(), moved);
            } else {
                for (const std::uint16_t count : counts) sum += count;
                if (!held) model.read(time_s, counts);
            }
            held_n = sum * scale / share;
        }
        estimates.push_back(held ? Estimate{.force_n = held_n} : model.at(seconds(now)));
    }
    return estimates;
}

}  // namespace

const std::vector<NamedDecoder>& named_decoders() {
    static const std::vector<NamedDecoder> list{{"sliding_window", SlidingWindowParameters()},
                                                {"exponential", ExponentialParameters()},
                                                {"interval", InverseIntervalParameters()},
                                                {"inversion", InversionParameters()},
                                                {"filter", FilterParameters()}};
    return list;
}

std::vector<Estimate> follow_events(const TouchedForce& force, const DecodingCell& cell,
                                    GripDecoder decoder) {
    std::vector<Event> events = force.activity.events;
    for (Event& event : events) event.time -= (event.time - scene_start) % *cell.tick;
    std::sort(events.begin(), events.end());
    std::mt19937_64 random(cell.draw);
    std::bernoulli_distribution lost(cell.lost);
    std::vector<Estimate> estimates;
    auto first = events.begin();
    TimePoint begin = scene_start;
    for (std::size_t k = 0; k < force.true_n.size(); ++k) {
        const TimePoint now = scene_start + static_cast<Duration::rep>(k) * Touch::step;
        for (; begin + cell.deadline + delivery <= now; begin += cell.deadline) {
            const TimePoint end = begin + cell.deadline;
            const auto last = std::partition_point(first, events.end(),
                                                   [end](const Event& event) { return event.time < end; });
            if (!lost(random)) decoder.observe(begin, end, {first, last});
            first = last;
        }
        estimates.push_back(decoder.estimate(now));
    }
    return estimates;
}

std::vector<DecodingCell> decoding_cells(const Touch& touch, bool quick) {
    std::vector<DecodingCell> cells;
    const Duration interval = touch.activity.frame_interval;
    using Durations = std::vector<Duration>;
    const Durations deadlines = quick ? Durations{5ms, 20ms} : Durations{2ms, 5ms, 10ms, 20ms, 50ms};
    for (const NamedDecoder& decoder : named_decoders())
        for (const Duration tick : quick ? Durations{100us} : Durations{10us, 100us, 1ms})
            for (const Duration deadline : deadlines)
                cells.push_back({"events", decoder.name, tick, deadline});
    for (const char* const decoder : {"force_model", "hold"}) {
        for (const char* const scheme : {"raw12", "delta_varint"})
            for (const Duration sampled : {5ms, 10ms, 20ms, 50ms, 100ms}) {
                const auto every = static_cast<std::uint32_t>(std::max<Duration::rep>(1, sampled / interval));
                cells.push_back({scheme, decoder, {}, every * interval, every});
                for (const Duration deadline : deadlines)
                    if (deadline > every * interval && deadline % (every * interval) == Duration(0))
                        cells.push_back({scheme, decoder, {}, deadline, every});
            }
        for (const double delta : {0.002, 0.005, 0.01, 0.02, 0.05, 0.1})
            for (const Duration deadline : deadlines)
                if (deadline >= interval && deadline % interval == Duration(0))
                    cells.push_back({"send_on_delta", decoder, {}, deadline, 1, delta});
    }
    return cells;
}

double bytes_per_s(const LinkActivity& activity, const DecodingCell& cell) {
    const Duration interval = cell.every_scan * activity.frame_interval;
    const std::uint64_t bytes = cell.tick ? event_bytes(activity, *cell.tick, cell.deadline)
                                          : framed_bytes(sample_payloads(activity, cell),
                                                         scans_per_packet(activity, cell) * interval);
    return static_cast<double>(bytes) / activity.seconds_long();
}

std::vector<FollowedForce> follow(const Touch& touch, const DecodingCell& cell) {
    const auto decoder_of = [&](const TouchedForce& force) {
        DecodedAfferents afferents = force.afferents;
        afferents.tick = *cell.tick;
        return make_decoder(decoder_named(cell.decoder), afferents);
    };
    std::vector<FollowedForce> followed;
    for (const TouchedForce& force : touch.forces)
        if (force.touched())
            followed.push_back(
                {force.true_n, force.sensed_n, force.decodable_n(),
                 cell.tick ? follow_events(force, cell, decoder_of(force)) : follow_samples(force, cell)});
    return followed;
}

std::vector<DecodingRow> measure_decoding(const std::vector<Touch>& touches, bool quick,
                                          const std::function<void(double)>& progress) {
    std::vector<DecodingRow> rows;
    for (const Touch& touch : touches)
        for (DecodingCell& cell : decoding_cells(touch, quick))
            rows.push_back({.touch = &touch, .cell = std::move(cell)});
    std::mutex reporting;
    std::size_t done = 0;
    // Differences of samples are the same samples: what is decoded of them is decoded once.
    const auto decoded_as = [&](const DecodingRow& row) {
        return std::find_if(rows.begin(), rows.end(), [&](const DecodingRow& other) {
            return other.touch == row.touch && other.cell.scheme == "raw12" &&
                   other.cell.decoder == row.cell.decoder && other.cell.deadline == row.cell.deadline &&
                   other.cell.every_scan == row.cell.every_scan;
        });
    };
    Workers(std::max(1U, std::thread::hardware_concurrency())).run(rows.size(), [&](std::size_t i) {
        // The largest touches are the last, and take longest.
        DecodingRow& row = rows[rows.size() - 1 - i];
        row.bytes_per_s = bytes_per_s(row.touch->activity, row.cell);
        if (row.cell.scheme != "delta_varint") row.score = score(follow(*row.touch, row.cell), Touch::step);
        const std::lock_guard lock(reporting);
        progress(static_cast<double>(++done) / static_cast<double>(rows.size()));
    });
    for (DecodingRow& row : rows) {
        if (row.cell.scheme == "delta_varint") row.score = decoded_as(row)->score;
        if (row.cell.decoder == "hold") row.score.coverage_95.reset();
        const WanderLimits limits{row.touch->wander_n2_per_s()};
        const double bits_per_s = 8 * row.bytes_per_s / static_cast<double>(row.touch->touched());
        const double limit =
            limits.aged(limits.causal(bits_per_s), seconds(row.cell.deadline), seconds(delivery));
        row.times_the_limit = row.score.rms_n / std::sqrt(limit);
    }
    return rows;
}

}  // namespace afferent
