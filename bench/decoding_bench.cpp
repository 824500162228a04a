#include "bench/decoding_bench.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <random>
#include <stdexcept>
#include <thread>
#include <utility>

#include "afferent/runtime/parallel.hpp"
#include "bench/change_coder.hpp"
#include "bench/event_packets.hpp"
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
    const auto rule = change_rule(activity, cell);
    std::vector<std::string> payloads;
    std::vector<std::uint16_t> counts;
    std::vector<std::uint16_t> before(activity.elements, 0);
    std::vector<CountChange> changes;
    SentCounts sender(activity.elements, rule.value_or(ChangeRule()));
    ChangeCoder coder(activity.elements, rule && rule->linear);
    ChangeCoder receiver = coder;
    std::vector<CountChange> received;
    for (std::size_t first = 0; first + batch <= sent_scans; first += batch) {
        std::string& payload = payloads.emplace_back();
        counts.clear();
        changes.clear();
        for (std::uint32_t i = 0; i < batch; ++i) {
            const Counts scan = activity.scan((first + i) * cell.every_scan);
            if (cell.scheme == "delta_varint") {
                encode_differences(scan, before, payload);
                before.assign(scan.begin(), scan.end());
            } else if (rule) {
                sender.send(scan, i * activity.elements, changes);
            } else {
                counts.insert(counts.end(), scan.begin(), scan.end());
            }
        }
        if (!rule) {
            encode_raw(counts, 12, payload);
            continue;
        }
        coder.encode(changes, batch, payload);
        if (!receiver.decode(payload, batch, received) || received != changes)
            throw std::runtime_error(cell.scheme + ": what was encoded does not come back");
    }
    return payloads;
}

std::vector<Estimate> follow_samples(const TouchedForce& force, const DecodingCell& cell) {
    const LinkActivity& activity = force.activity;
    const std::uint32_t batch = scans_per_packet(activity, cell);
    const Duration interval = cell.every_scan * activity.frame_interval;
    const bool held = cell.decoder == "hold";
    const double scale = activity.newtons_per_count;
    const auto rule = change_rule(activity, cell);
    SentCounts sender(activity.elements, rule.value_or(ChangeRule()));
    SampledForce model(force);
    std::vector<CountChange> changes;
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
            if (rule) {
                changes.clear();
                sender.send(counts, 0, changes);
                for (std::uint32_t e = 0; e < activity.elements; ++e) sum += sender.presumed(e);
                if (!held) model.read_changes(time_s, sender);
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

// The estimates of one force. Its afferents have the addresses from `first` on. A spike that was foreseen is
// given to the decoder when the packet that confirms it arrives.
std::vector<Estimate> follow_told(const TouchedForce& force, Address first,
                                  const std::vector<ToldSpan>& spans, GripDecoder decoder) {
    std::vector<Estimate> estimates;
    std::vector<Event> own;
    auto next = spans.begin();
    for (std::size_t k = 0; k < force.true_n.size(); ++k) {
        const TimePoint now = scene_start + static_cast<Duration::rep>(k) * Touch::step;
        for (; next != spans.end() && next->closes + delivery <= now; ++next) {
            own.clear();
            for (const auto& [time, address] : next->events)
                if (address >= first && address - first < force.activity.addresses)
                    own.push_back({time, address - first});
            decoder.observe(next->begin, next->end, own);
        }
        estimates.push_back(decoder.estimate(now));
    }
    return estimates;
}

// With a tolerance, a span without a packet may have had spikes, and is no silence.
bool presumes_events(const DecodingCell& cell) { return cell.tolerance.value_or(0ns) > 0ns; }

}  // namespace

std::optional<ChangeRule> change_rule(const LinkActivity& activity, const DecodingCell& cell) {
    if (cell.scheme == "delta_coded") return ChangeRule();
    if (!cell.delta) return std::nullopt;
    const int band = std::max(1, static_cast<int>(std::lround(*cell.delta * 4095)));
    if (cell.dead_band) return dead_band_rule(activity, *cell.dead_band, band);
    return ChangeRule{.band = band, .linear = cell.scheme == "linear_prediction"};
}

DecodingCell told_alike(DecodingCell cell) {
    if (cell.scheme == "delta_varint" || cell.scheme == "delta_coded") cell.scheme = "raw12";
    if (cell.tolerance == Duration(0)) {
        cell.scheme = "events";
        cell.tolerance.reset();
    }
    return cell;
}

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
    // Predicted: to the tick, where the estimates are those of the events above, and within a tolerance.
    for (const Duration tick : quick ? Durations{100us} : Durations{100us, 1ms})
        for (const Duration deadline : deadlines)
            for (const Duration tolerance :
                 quick ? Durations{0us, 500us} : Durations{0us, 200us, 500us, 1ms, 2ms})
                if (tolerance % tick == Duration(0) && 2 * tolerance < deadline)
                    cells.push_back({.scheme = "predicted",
                                     .decoder = "filter",
                                     .tick = tick,
                                     .deadline = deadline,
                                     .tolerance = tolerance});
    for (const char* const decoder : {"force_model", "hold"}) {
        for (const char* const scheme : {"raw12", "delta_varint", "delta_coded"})
            for (const Duration sampled : {5ms, 10ms, 20ms, 50ms, 100ms}) {
                const auto every = static_cast<std::uint32_t>(std::max<Duration::rep>(1, sampled / interval));
                cells.push_back({scheme, decoder, {}, every * interval, every});
                for (const Duration deadline : deadlines)
                    if (deadline > every * interval && deadline % (every * interval) == Duration(0))
                        cells.push_back({scheme, decoder, {}, deadline, every});
            }
        for (const Duration deadline : deadlines) {
            if (deadline < interval || deadline % interval != Duration(0)) continue;
            for (const char* const scheme : {"send_on_delta", "linear_prediction"})
                for (const double delta : {0.002, 0.005, 0.01, 0.02, 0.05, 0.1})
                    cells.push_back({scheme, decoder, {}, deadline, 1, delta});
            for (const double dead_band : {0.02, 0.05, 0.1, 0.2})
                for (const double least : {0.0, 0.01})
                    cells.push_back({"dead_band", decoder, {}, deadline, 1, least, dead_band});
        }
    }
    return cells;
}

double bytes_per_s(const LinkActivity& activity, const DecodingCell& cell) {
    const Duration interval = cell.every_scan * activity.frame_interval;
    const std::uint64_t bytes =
        cell.tick
            ? event_bytes(activity, event_layout(activity, *cell.tick, cell.deadline, cell.tolerance))
            : framed_bytes(sample_payloads(activity, cell), scans_per_packet(activity, cell) * interval);
    return static_cast<double>(bytes) / activity.seconds_long();
}

std::vector<FollowedForce> follow(const Touch& touch, const DecodingCell& cell) {
    const auto decoder_of = [&](const TouchedForce& force) {
        DecodedAfferents afferents = force.afferents;
        afferents.tick = *cell.tick + 2 * cell.tolerance.value_or(0ns);
        return make_decoder(decoder_named(cell.decoder), afferents);
    };
    std::vector<ToldSpan> spans;
    if (presumes_events(cell))
        spans = told_spans(touch.activity,
                           event_layout(touch.activity, *cell.tick, cell.deadline, cell.tolerance));
    std::vector<FollowedForce> followed;
    Address first = 0;
    for (const TouchedForce& force : touch.forces) {
        const Address own = std::exchange(first, first + force.activity.addresses);
        if (!force.touched()) continue;
        followed.push_back({force.true_n, force.sensed_n, force.decodable_n(), {}});
        std::vector<Estimate>& estimates = followed.back().estimates;
        if (presumes_events(cell))
            estimates = follow_told(force, own, spans, decoder_of(force));
        else if (cell.tick)
            estimates = follow_events(force, cell, decoder_of(force));
        else
            estimates = follow_samples(force, cell);
    }
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
    // Cells that tell the other end the same are decoded once.
    const auto decoded_as = [&](const DecodingRow& row) {
        return std::find_if(rows.begin(), rows.end(), [&, cell = told_alike(row.cell)](const auto& other) {
            return other.touch == row.touch && other.cell == cell;
        });
    };
    const auto has_own_score = [](const DecodingRow& row) { return told_alike(row.cell) == row.cell; };
    Workers(std::max(1U, std::thread::hardware_concurrency())).run(rows.size(), [&](std::size_t i) {
        // The largest touches are the last, and take longest.
        DecodingRow& row = rows[rows.size() - 1 - i];
        row.bytes_per_s = bytes_per_s(row.touch->activity, row.cell);
        if (has_own_score(row)) row.score = score(follow(*row.touch, row.cell), Touch::step);
        const std::lock_guard lock(reporting);
        progress(static_cast<double>(++done) / static_cast<double>(rows.size()));
    });
    for (DecodingRow& row : rows) {
        if (!has_own_score(row)) row.score = decoded_as(row)->score;
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
