// Question: what does a byte buy? The error of the force against the bytes per second that a link carries,
// for events with every decoder and for every honest alternative, under the same packets and delays.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "afferent/decoders/decoders.hpp"
#include "afferent/decoders/grip_decoder.hpp"
#include "bench/force_score.hpp"
#include "bench/sent_counts.hpp"
#include "bench/touch.hpp"

namespace afferent {

// A way to send a touch and to estimate its force.
struct DecodingCell {
    std::string scheme;   // as in bandwidth.csv
    std::string decoder;  // "force_model" of samples: the best that is known; "hold": the last one stands
    std::optional<Duration> tick = {};
    // Packets close at its multiples; what is sampled less often is sent at once.
    Duration deadline{};
    // Of samples: which of the sensors' scans are sent (every one, every second, ...).
    std::uint32_t every_scan = 1;
    // Of schemes that send changes: the least change that is sent, as a fraction of one element's full scale.
    // `dead_band` is the same as a fraction of the value that was sent last.
    std::optional<double> delta = {};
    std::optional<double> dead_band = {};
    std::optional<Duration> tolerance = {};  // of events that are predicted; a multiple of the tick
    // Of events: the part of the packets that is lost, each by itself.
    double lost = 0;
    std::uint64_t draw = 0;  // of those

    bool operator==(const DecodingCell&) const = default;
};

// Some cells differ only in how they are coded: the other end learns the same at the same times, and
// estimates the same. Returns the one that stands for all of them, which may be the given cell.
DecodingCell told_alike(DecodingCell cell);

// Every decoder, by the name that it has in tables, with its default parameters.
struct NamedDecoder {
    const char* name;
    DecoderParameters parameters;
};
const std::vector<NamedDecoder>& named_decoders();

// Of each packet, from its end to its use.
inline constexpr Duration delivery = 2ms;

// The cells that are measured on this touch.
std::vector<DecodingCell> decoding_cells(const Touch& touch, bool quick);

// By which rule the cell's samples are sent; nothing where all of them are.
std::optional<ChangeRule> change_rule(const LinkActivity& activity, const DecodingCell& cell);

// What the cell's packets carry, framing and heartbeats included.
double bytes_per_s(const LinkActivity& activity, const DecodingCell& cell);

// The estimates of the forces that are touched, step by step; what is known at a step are the packets that
// have been delivered by then.
std::vector<FollowedForce> follow(const Touch& touch, const DecodingCell& cell);

// The estimates of one force from its events, by a decoder that has heard nothing yet. The cell's own decoder
// does not count.
std::vector<Estimate> follow_events(const TouchedForce& force, const DecodingCell& cell, GripDecoder decoder);

struct DecodingRow {
    const Touch* touch;
    DecodingCell cell;
    double bytes_per_s = 0;
    ForceScore score = {};
    // The RMS error over that of the least which a code of so many bits in packets can have of a wandering
    // force (wander_limits.hpp).
    double times_the_limit = 0;
};

// Every cell of every touch, on all processors. The touches must outlive the result. `progress` is told the
// fraction that is done, from one thread at a time.
std::vector<DecodingRow> measure_decoding(const std::vector<Touch>& touches, bool quick,
                                          const std::function<void(double)>& progress);

}  // namespace afferent
