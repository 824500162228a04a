#include "bench/link_schemes.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/spike_predictor.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "bench/alternatives.pb.h"
#include "bench/change_coder.hpp"
#include "bench/event_packets.hpp"
#include "bench/sample_coding.hpp"

namespace afferent {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int repetitions = 5;

double median(std::array<double, repetitions> values) {
    std::sort(values.begin(), values.end());
    return values[repetitions / 2];
}

// A way to code packets, numbered from 0. It holds their contents, and can check that decoding returns them.
struct Coding {
    std::size_t packets = 0;
    std::size_t items = 0;  // events or samples, in all packets
    std::function<void(std::size_t, std::string&)> encode;
    // Decodes into its own memory. With `check`: whether that is what was encoded.
    std::function<bool(std::size_t, const std::string&, bool)> decode;
};

// Encodes all packets, checks that decoding returns them, and times both. Returns the payloads.
std::vector<std::string> run(const Coding& coding, SchemeResult& result) {
    std::vector<std::string> payloads(coding.packets);
    for (std::size_t i = 0; i < coding.packets; ++i) {
        coding.encode(i, payloads[i]);
        if (!coding.decode(i, payloads[i], true))
            throw std::runtime_error(result.scheme + ": what was encoded does not come back");
    }
    if (coding.items == 0) return payloads;
    std::array<double, repetitions> encode_ns;
    std::array<double, repetitions> decode_ns;
    for (int repetition = 0; repetition < repetitions; ++repetition) {
        const auto begin = Clock::now();
        for (std::size_t i = 0; i < coding.packets; ++i) coding.encode(i, payloads[i]);
        const auto middle = Clock::now();
        for (std::size_t i = 0; i < coding.packets; ++i) coding.decode(i, payloads[i], false);
        const auto end = Clock::now();
        const auto items = static_cast<double>(coding.items);
        encode_ns[static_cast<std::size_t>(repetition)] = Interval(middle - begin).count() / items;
        decode_ns[static_cast<std::size_t>(repetition)] = Interval(end - middle).count() / items;
    }
    result.encode_ns = median(encode_ns);
    result.decode_ns = median(decode_ns);
    return payloads;
}

// The events of each packet as a decoder needs them: tick within the packet, address.
struct TickedEvents {
    std::vector<Code> codes;
    std::vector<std::size_t> begins;  // of each packet; the last is the end

    std::span<const Code> packet(std::size_t i) const {
        return std::span(codes).subspan(begins[i], begins[i + 1] - begins[i]);
    }
};

TickedEvents ticked(const LinkActivity& activity, const PacketLayout& layout) {
    TickedEvents ticked;
    ticked.codes.reserve(activity.events.size());
    auto event = activity.events.begin();
    for (TimePoint begin = scene_start; begin < scene_start + activity.duration; begin += layout.span) {
        ticked.begins.push_back(ticked.codes.size());
        for (; event != activity.events.end() && event->time < begin + layout.span; ++event)
            ticked.codes.push_back(
                static_cast<Code>((event->time - begin) / layout.tick * layout.addresses + event->address));
        std::sort(ticked.codes.begin() + static_cast<std::ptrdiff_t>(ticked.begins.back()),
                  ticked.codes.end());
    }
    ticked.begins.push_back(ticked.codes.size());
    return ticked;
}

// Measures a scheme that sends an element when its count has changed.
SchemeResult measure_changes(SchemeResult result, const LinkActivity& activity, const ChangeRule& rule) {
    result.deadline = activity.frame_interval;
    // The changes to send are found before timing.
    SentCounts sender(activity.elements, rule);
    std::vector<std::vector<CountChange>> frames(activity.scans());
    std::size_t items = 0;
    for (std::size_t i = 0; i < frames.size(); ++i) {
        sender.send(activity.scan(i), 0, frames[i]);
        items += frames[i].size();
    }
    // Both ends learn from one payload for the next, so each pass over them starts over.
    const ChangeCoder start(activity.elements, rule.linear);
    ChangeCoder sending = start;
    ChangeCoder receiving = start;
    std::vector<CountChange> decoded;
    result.bytes = framed_bytes(run({.packets = frames.size(),
                                     .items = items,
                                     .encode =
                                         [&](std::size_t i, std::string& payload) {
                                             if (i == 0) sending = start;
                                             sending.encode(frames[i], 1, payload);
                                         },
                                     .decode =
                                         [&](std::size_t i, const std::string& payload, bool check) {
                                             if (i == 0) receiving = start;
                                             return receiving.decode(payload, 1, decoded) &&
                                                    (!check || decoded == frames[i]);
                                         }},
                                    result),
                                activity.frame_interval);
    return result;
}

// The entropy −Σ p log2 p of how often an address fires in a tick, over all addresses and ticks, in bytes.
double poisson_entropy_bytes(const LinkActivity& activity, Duration tick, double rate_hz) {
    const double mean = rate_hz * seconds(tick);
    double bits = 0;
    double p = std::exp(-mean);
    for (int events = 0; events < 30 && p > 0; p *= mean / ++events) bits -= p * std::log2(p);
    return bits / 8 * activity.addresses * static_cast<double>(activity.duration / tick);
}

}  // namespace

std::uint64_t framed_bytes(const std::vector<std::string>& payloads, Duration span) {
    FrameWriter writer;
    proto::Envelope packet;
    std::uint64_t bytes = 0;
    Duration silence = Duration::zero();
    // As packets of predicted spikes: where a packet ends is said in silence and with every sixteenth.
    int without_position = 0;
    for (std::size_t i = 0; i < payloads.size(); ++i) {
        silence += span;
        if (payloads[i].empty() && silence < link_heartbeat) continue;
        const bool implied = !payloads[i].empty() && ++without_position < 16;
        if (!implied) without_position = 0;
        packet.set_position(implied ? 0 : static_cast<std::uint32_t>((i + 1) % position_modulus) + 1);
        packet.set_spans(implied && silence > span ? static_cast<std::uint32_t>(silence / span) : 0);
        packet.set_payload(payloads[i]);
        bytes += writer.stream_frame(packet).size();
        silence = Duration::zero();
    }
    return bytes;
}

int counts_of(double force_n, const LinkActivity& activity) {
    return std::max(1, static_cast<int>(std::lround(force_n / activity.newtons_per_count)));
}

SchemeResult measure_events(const LinkActivity& activity, Duration tick, Duration deadline,
                            std::optional<double> poisson_rate_hz) {
    SchemeResult result{.scheme = "events", .tick = tick, .deadline = deadline};
    const PacketLayout layout = event_layout(activity, tick, deadline);
    result.bytes = event_bytes(activity, layout);
    if (poisson_rate_hz)
        result.poisson_ratio =
            static_cast<double>(result.bytes) / poisson_entropy_bytes(activity, tick, *poisson_rate_hz);

    const TickedEvents events = ticked(activity, layout);
    // A packet with more events than fit is sent in several parts.
    PayloadCodec codec(layout);
    const auto first_part = [&](std::size_t i) {
        const auto codes = events.packet(i);
        return codes.first(std::min<std::size_t>(codes.size(), layout.max_events));
    };
    std::size_t items = 0;
    for (std::size_t i = 0; i + 1 < events.begins.size(); ++i) items += first_part(i).size();
    run({.packets = events.begins.size() - 1,
         .items = items,
         .encode = [&](std::size_t i, std::string& payload) { codec.encode(first_part(i), payload); },
         .decode =
             [&](std::size_t i, const std::string& payload, bool check) {
                 const auto codes = codec.decode(std::as_bytes(std::span(payload)));
                 return codes && (!check || std::ranges::equal(codes.value(), first_part(i)));
             }},
        result);
    return result;
}

std::optional<SchemeResult> measure_predicted(const LinkActivity& activity, Duration tick, Duration deadline,
                                              Duration tolerance) {
    const PacketLayout layout = event_layout(activity, tick, deadline, tolerance);
    try {
        layout.check();
    } catch (const ParameterError&) {
        return std::nullopt;
    }
    SchemeResult result{.scheme = "predicted", .tick = tick, .deadline = deadline, .tolerance = tolerance};
    result.bytes = event_bytes(activity, layout);
    const TickedEvents events = ticked(activity, layout);
    SpikePredictor coprocessor(layout);
    SpikePredictor hand(layout);
    // A payload refers to those before it, so each pass over them starts over.
    const auto start_over = [](std::size_t i, SpikePredictor& predictor) {
        if (i == 0) predictor.restart(0);
    };
    const auto room = [&](std::size_t i) {
        const auto codes = events.packet(i);
        return codes.first(std::min<std::size_t>(codes.size(), layout.max_events - coprocessor.waiting()));
    };
    double bits = 0;  // of the pass at hand
    run({.packets = events.begins.size() - 1,
         .items = events.codes.size(),
         .encode =
             [&](std::size_t i, std::string& payload) {
                 start_over(i, coprocessor);
                 coprocessor.encode(room(i), payload, {});
                 bits = (i == 0 ? 0 : bits) + coprocessor.information_bits();
             },
         .decode =
             [&](std::size_t i, const std::string& payload, bool check) {
                 start_over(i, hand);
                 const auto codes = hand.decode(std::as_bytes(std::span(payload)), false);
                 if (!codes || (check && hand.check() != coprocessor.check())) return false;
                 return !check || tolerance > 0ns || std::ranges::equal(codes.value(), events.packet(i));
             }},
        result);
    if (tolerance > 0ns || events.codes.empty()) return result;
    const auto count = static_cast<double>(events.codes.size());
    result.causal_bits = bits / count;
    const double mean_hz = count / activity.addresses / activity.seconds_long();
    result.poisson_bits = 8 * poisson_entropy_bytes(activity, tick, mean_hz) / count;
    return result;
}

SchemeResult measure_repeated_messages(const LinkActivity& activity, Duration tick, Duration deadline) {
    SchemeResult result{.scheme = "repeated_messages", .tick = tick, .deadline = deadline};
    const PacketLayout layout = event_layout(activity, tick, deadline);
    const TickedEvents events = ticked(activity, layout);
    proto::RepeatedEvents message;
    result.bytes = framed_bytes(
        run({.packets = events.begins.size() - 1,
             .items = events.codes.size(),
             .encode =
                 [&](std::size_t i, std::string& payload) {
                     message.Clear();
                     const Duration begin = static_cast<std::int64_t>(i) * deadline;
                     for (const Code code : events.packet(i)) {
                         proto::TimedAddress& event = *message.add_event();
                         event.set_time_ns(
                             static_cast<std::uint64_t>((begin + code / layout.addresses * tick).count()));
                         event.set_address(code % layout.addresses);
                     }
                     message.SerializeToString(&payload);
                 },
             .decode =
                 [&](std::size_t i, const std::string& payload, bool check) {
                     if (!message.ParseFromString(payload)) return false;
                     const auto codes = events.packet(i);
                     if (static_cast<std::size_t>(message.event_size()) != codes.size()) return false;
                     for (int e = 0; check && e < message.event_size(); ++e)
                         if (message.event(e).address() !=
                             codes[static_cast<std::size_t>(e)] % layout.addresses)
                             return false;
                     return true;
                 }},
            result),
        deadline);
    return result;
}

SchemeResult measure_packed_columns(const LinkActivity& activity, Duration tick, Duration deadline) {
    SchemeResult result{.scheme = "packed_columns", .tick = tick, .deadline = deadline};
    const PacketLayout layout = event_layout(activity, tick, deadline);
    const TickedEvents events = ticked(activity, layout);
    proto::PackedColumns message;
    result.bytes = framed_bytes(
        run({.packets = events.begins.size() - 1,
             .items = events.codes.size(),
             .encode =
                 [&](std::size_t i, std::string& payload) {
                     message.Clear();
                     std::uint32_t last = 0;
                     for (const Code code : events.packet(i)) {
                         const std::uint32_t at = code / layout.addresses;
                         message.add_ticks(at - last);
                         message.add_address(code % layout.addresses);
                         last = at;
                     }
                     message.SerializeToString(&payload);
                 },
             .decode =
                 [&](std::size_t i, const std::string& payload, bool check) {
                     if (!message.ParseFromString(payload)) return false;
                     const auto codes = events.packet(i);
                     if (static_cast<std::size_t>(message.address_size()) != codes.size()) return false;
                     std::uint32_t at = 0;
                     for (int e = 0; check && e < message.address_size(); ++e) {
                         at += message.ticks(e);
                         if (at * layout.addresses + message.address(e) != codes[static_cast<std::size_t>(e)])
                             return false;
                     }
                     return true;
                 }},
            result),
        deadline);
    return result;
}

SchemeResult measure_raw(const LinkActivity& activity, unsigned bits) {
    SchemeResult result{.scheme = "raw" + std::to_string(bits), .deadline = activity.frame_interval};
    std::vector<std::uint16_t> decoded(activity.elements);
    result.bytes = framed_bytes(run({.packets = activity.scans(),
                                     .items = activity.counts.size(),
                                     .encode =
                                         [&](std::size_t i, std::string& payload) {
                                             payload.clear();
                                             encode_raw(activity.scan(i), bits, payload);
                                         },
                                     .decode =
                                         [&](std::size_t i, const std::string& payload, bool check) {
                                             return decode_raw(payload, bits, decoded) &&
                                                    (!check || std::ranges::equal(decoded, activity.scan(i)));
                                         }},
                                    result),
                                activity.frame_interval);
    return result;
}

SchemeResult measure_delta_varint(const LinkActivity& activity) {
    SchemeResult result{.scheme = "delta_varint", .deadline = activity.frame_interval};
    const std::vector<std::uint16_t> zeros(activity.elements);
    const auto before = [&](std::size_t i) { return i == 0 ? Counts(zeros) : activity.scan(i - 1); };
    std::vector<std::uint16_t> decoded(activity.elements);
    result.bytes = framed_bytes(run({.packets = activity.scans(),
                                     .items = activity.counts.size(),
                                     .encode =
                                         [&](std::size_t i, std::string& payload) {
                                             payload.clear();
                                             encode_differences(activity.scan(i), before(i), payload);
                                         },
                                     .decode =
                                         [&](std::size_t i, const std::string& payload, bool check) {
                                             return decode_differences(payload, before(i), decoded) &&
                                                    (!check || std::ranges::equal(decoded, activity.scan(i)));
                                         }},
                                    result),
                                activity.frame_interval);
    return result;
}

SchemeResult measure_delta_coded(const LinkActivity& activity) {
    return measure_changes({.scheme = "delta_coded"}, activity, ChangeRule());
}

SchemeResult measure_send_on_delta(const LinkActivity& activity, double delta_n) {
    return measure_changes({.scheme = "send_on_delta", .delta_n = delta_n}, activity,
                           {.band = counts_of(delta_n, activity)});
}

SchemeResult measure_linear_prediction(const LinkActivity& activity, double delta_n) {
    return measure_changes({.scheme = "linear_prediction", .delta_n = delta_n}, activity,
                           {.band = counts_of(delta_n, activity), .linear = true});
}

SchemeResult measure_dead_band(const LinkActivity& activity, double fraction, double delta_n) {
    return measure_changes({.scheme = "dead_band", .delta_n = delta_n, .dead_band = fraction}, activity,
                           dead_band_rule(activity, fraction, counts_of(delta_n, activity)));
}

ChangeRule dead_band_rule(const LinkActivity& activity, double fraction, int least) {
    constexpr double deviations = 4;
    return {.band = std::max(least, static_cast<int>(std::ceil(deviations * activity.noise_counts))),
            .fraction = fraction};
}

}  // namespace afferent
