#include "afferent/scene/plan_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/spike_predictor.hpp"
#include "afferent/neurons/rate.hpp"
#include "afferent/scene/shard_bytes.hpp"

namespace afferent {
namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();

// The forces between which a sensor's samples lie.
struct Range {
    double lowest_n;
    double highest_n;
};

Range range_of(const PatchPlan& patch) {
    Range range{0, patch.sensor.full_scale_n};
    for (const Calibration::Point& point : patch.sensor.calibration) {
        range.lowest_n = std::min(range.lowest_n, point.force_n);
        range.highest_n = std::max(range.highest_n, point.force_n);
    }
    return range;
}

// The largest input to the encoder of an afferent that reads that much of the patch's elements.
double largest_input(const Plan& plan, const PatchPlan& patch, double weight) {
    const Range range = range_of(patch);
    // Samples that come at times of their own may come at any pace.
    std::optional<Interval> sampling;
    if (traits_of(plan.scene.source).clocked) sampling = patch.scan_interval;
    const double range_n = patch.proportional() ? range.highest_n : range.highest_n - range.lowest_n;
    return afferent::largest_input(patch.encoder, weight * range_n, sampling);
}

double events_per_second(const Plan& plan, const PatchPlan& patch) {
    if (patch.fields.is_one_each() && patch.variations.empty())
        return patch.afferents() * highest_rate_hz(plan, patch, 0);
    double sum = 0;
    for (std::uint32_t i = 0; i < patch.afferents(); ++i) sum += highest_rate_hz(plan, patch, i);
    return sum;
}

// One event of a full packet of n events out of `codes`, as io/wire/payload.hpp writes them. A Rice code
// takes at most log2(codes/n) + 2 bits, and the packet a byte. Shorter packets have fewer of both.
double event_bytes(const PacketLayout& layout, double events) {
    const double codes = static_cast<double>(layout.codes());
    if (layout.encoding == Encoding::fixed_width) return std::ceil(std::log2(codes) / 8);
    const double listed = std::log2(std::max(1.0, codes / events)) + 2;
    // Its own symbol or place in the list, and the symbols which say that the spike foreseen after it did not
    // come: together these take no more than one.
    constexpr double symbol = SpikePredictor::most_symbol_bits;
    if (layout.encoding == Encoding::predicted) return (symbol + std::max(symbol, listed + 4)) / 8;
    return listed / 8;
}

// Length, envelope and checksum of an empty packet, and of any other one.
constexpr double resting_frame_bytes = 8;
constexpr double frame_bytes = 26;

// What the transport adds to each packet.
double transport_bytes(const Plan& plan) {
    constexpr double tls_record = 5 + 1 + 16;  // header, kind, tag
    const scene::Link& link = plan.scene.link;
    if (!plan.over_datagrams) return link.keys ? tls_record : 0;
    return (link.keys ? static_cast<double>(longest_seal_bytes) : 0) + traits_of(link.transport).cobs_bytes;
}

void add_bytes_per_second(Plan& plan) {
    const PacketLayout& layout = *plan.packets;
    const double bus_limit = plan.bus ? 1 / seconds(plan.bus->cycle) : unbounded;
    const double events = std::min(plan.events_per_second, bus_limit);
    const Duration gathered = layout.gathered_spans * layout.span;
    // At worst touches begin one after another: a heartbeat of silence with one packet, and then one packet
    // in each span for a heartbeat and a span.
    const double heartbeat = layout.heartbeat_spans();
    const double prompt = (heartbeat + 2) / ((2 * heartbeat + 1) * seconds(layout.span));
    const double packets = std::max(1 / seconds(gathered), prompt);
    // A full packet is followed by further ones.
    const double frames = packets + events / layout.max_events;
    const double extra = traits_of(plan.scene.link.transport).cobs_factor;
    plan.bytes_per_second =
        std::isinf(events)
            ? unbounded
            : extra * (frames * (frame_bytes + transport_bytes(plan)) +
                       (events > 0 ? events * event_bytes(layout, events * seconds(gathered)) : 0));
    plan.resting_bytes_per_second =
        (resting_frame_bytes + transport_bytes(plan)) / (layout.heartbeat_spans() * seconds(layout.span));
}

// Whether samples, events and packets come at times that the scene decides.
bool is_clocked(const Plan& plan) {
    const bool queues = plan.bus || (plan.scene.link.channel && plan.scene.link.channel->bandwidth_bps > 0);
    return !queues && traits_of(plan.scene.source).clocked;
}

// The longest time from a packet's closing until it acts, over the emulated channel. The channel may delay a
// packet twice, and a packet that has overtaken others waits for them.
Duration channel_delivery(const Plan& plan, const scene::Channel& channel) {
    const double once_ms = channel.latency_ms + channel.jitter_ms;
    return from_milliseconds(channel.reorder > 0 ? 2 * once_ms : once_ms) +
           (plan.over_datagrams ? plan.timing.overtaking : Duration::zero());
}

void add_latency(Plan& plan) {
    for (const PatchPlan& patch : plan.patches) {
        plan.latency.sampling = std::max(plan.latency.sampling, patch.scan_interval);
        // In whole scans.
        const Duration delay = from_milliseconds(patch.sensor.delay_ms);
        plan.latency.sensor = std::max(plan.latency.sensor, (delay + patch.scan_interval - 1ns) /
                                                                patch.scan_interval * patch.scan_interval);
        plan.latency.nerve = std::max(plan.latency.nerve, patch.conduction);
    }
    plan.latency.packet = plan.timing.span;
    plan.latency.delivery = plan.timing.delivery;
    if (const auto& channel = plan.scene.link.channel)
        plan.latency.delivery = std::max(plan.latency.delivery, channel_delivery(plan, *channel));
    plan.latency.step = from_seconds(1 / plan.controller->emg_rate_hz);
}

}  // namespace

double highest_rate_hz(const Plan& plan, const PatchPlan& patch, std::uint32_t afferent) {
    double weight = 0;
    if (patch.fields.is_one_each())
        weight = 1;
    else
        for (const auto& field : patch.fields.row(afferent)) weight += field.weight;
    const double input = largest_input(plan, patch, weight);
    if (std::isinf(input)) return unbounded;
    return highest_rate_hz(patch.neuron_of(afferent),
                           patch.gain() * input + patch.bias_mv() + patch.noise.largest_mv());
}

bool can_fire(const Plan& plan, const PatchPlan& patch) {
    for (std::uint32_t i = 0; i < patch.afferents(); ++i)
        if (highest_rate_hz(plan, patch, i) > 0) return true;
    return false;
}

void add_bounds(Plan& plan) {
    double bytes = 0;
    for (const Plan::ShardPlan& shard : plan.shards)
        bytes += static_cast<double>(shard_bytes(plan.patches[shard.patch], shard.begin, shard.count));
    plan.bytes_per_neuron = bytes / plan.addresses;
    plan.bytes_per_element = bytes / plan.elements;
    for (const PatchPlan& patch : plan.patches) plan.events_per_second += events_per_second(plan, patch);
    if (plan.packets) add_bytes_per_second(plan);
    if (plan.packets && plan.controller && is_clocked(plan)) add_latency(plan);
}

}  // namespace afferent
