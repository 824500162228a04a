#include "afferent/nodes/run_summary.hpp"
#include "afferent/nodes/coprocessor_end.hpp"
#include "afferent/nodes/coprocessor_report.hpp"
#include "afferent/nodes/grip_loop.hpp"
#include "afferent/nodes/hand_report.hpp"
#include "afferent/nodes/link_totals.hpp"

#include <algorithm>

namespace afferent {
namespace {

// Where a node stands, and the state of its session, if it has one.
Summary standing(const Scene& scene, TimePoint at, const Session* session, std::uint64_t sessions) {
    Summary status;
    status["scene"] = scene.name;
    status["at_s"] = seconds(at);
    status["session"] = name(session);
    status["sessions"] = sessions;
    if (session && !session->last_refusal().empty()) status["last_refusal"] = session->last_refusal();
    return status;
}

void add_live_events(Summary& summary, const std::vector<scene::Output>& outputs, std::uint64_t lost) {
    if (std::ranges::any_of(outputs, takes_events)) summary["lost_live_events"] = lost;
}

void add_link(Summary& summary, const LinkTotals& totals) {
    summary["bytes_sent"] = totals.bytes_sent;
    summary["bytes_received"] = totals.bytes_received;
    summary["checksum_failures"] = totals.checksum_failures;
    summary["refused_frames"] = totals.refused_frames;
    summary["forged_datagrams"] = totals.forged_datagrams;
    summary["repeated_datagrams"] = totals.repeated_datagrams;
}

// Only the filter judges afferents.
void add_left_out(Summary& summary, const Scene& scene, const Estimate& estimate) {
    if (is_filter(scene.decoder)) summary["left_out_afferents"] = estimate.left_out;
}

// How the neurons have been computed, where the scene is large enough for a choice.
void add_forms(Summary& summary, const Coprocessor& coprocessor) {
    if (!coprocessor.changes_forms()) return;
    summary["shards"] = coprocessor.shards();
    summary["dense_shards_at_end"] = coprocessor.dense_shards();
    summary["form_changes"] = coprocessor.form_changes();
}

void add_overdue(Summary& summary, const CoprocessorEnd& link_end) {
    if (link_end.overdue()) summary["skipped_samples"] = link_end.overdue()->skipped_samples();
}

void add_hand_on_line(Summary& summary, const HandReadings& hand) {
    summary["commands"] = hand.commands;
    summary["replies"] = hand.replies;
    summary["unanswered"] = hand.unanswered;
    summary["refused_frames"] = hand.refused_frames;
    summary["implausible_replies"] = hand.implausible_replies;
    summary["lost_lines"] = hand.lost_lines;
    summary["zeros_taken"] = hand.zeros_taken;
    summary["zeros_refused"] = hand.zeros_refused;
    summary["sample_to_command_p50_ms"] = Milliseconds(hand.sample_to_command_p50).count();
    summary["sample_to_command_p99_ms"] = Milliseconds(hand.sample_to_command_p99).count();
    summary["sample_to_command_max_ms"] = Milliseconds(hand.sample_to_command_max).count();
}

// What people should know of the tables that the samples and the EMG came from.
void add_notes(Summary& summary, const SampleSource* source, const HandEnd* hand) {
    std::vector<std::string> said;
    if (source) said = source->said();
    if (std::string clipped = source ? source->said_of_clipped() : ""; !clipped.empty())
        said.push_back(std::move(clipped));
    if (hand && hand->controller())
        said.insert(said.end(), hand->said_of_emg().begin(), hand->said_of_emg().end());
    for (std::string& sentence : said) summary["notes"].push_back(std::move(sentence));
}

}  // namespace

const char* name(GripState state) {
    return state == GripState::safe ? "safe" : state == GripState::frozen ? "frozen" : "operating";
}

const char* name(const Session* session) {
    return !session ? "none" : session->state() == Session::State::open ? "open" : "handshake";
}

void add_progress(Summary& summary, const char* link_end, const Scene& scene, TimePoint until) {
    summary["side"] = link_end;
    summary["scene"] = scene.name;
    summary["seed"] = scene.seed;
    summary["until_s"] = seconds(until);
    summary["complete"] = until >= scene.end();
}

void add_coprocessor(Summary& summary, const CoprocessorEnd& link_end) {
    summary["samples"] = link_end.samples();
    summary["clipped_samples"] = link_end.source() ? Summary(link_end.source()->clipped()) : Summary();
    summary["late_scans"] = link_end.coprocessor().late_scans();
    add_overdue(summary, link_end);
    summary["events"] = link_end.events();
    add_forms(summary, link_end.coprocessor());
    add_bus(summary, link_end.bus());
    summary["packets"] = link_end.packetizer()->packets();
    summary["raw_sample_bytes"] = link_end.raw_sample_bytes();
    add_notes(summary, link_end.source(), nullptr);
}

void add_bus(Summary& summary, const EventBus* bus) {
    if (!bus) return;
    const auto delay_us = [&](double share) { return static_cast<double>(bus->delay(share).count()) / 1e3; };
    summary["bus_events"] = bus->counts().events;
    summary["bus_collisions"] = bus->counts().collisions;
    summary["bus_dropped"] = bus->counts().dropped;
    summary["bus_delay_p50_us"] = delay_us(0.5);
    summary["bus_delay_p99_us"] = delay_us(0.99);
    summary["bus_delay_max_us"] = delay_us(1);
}

void add_pace(Summary& summary, const std::optional<Pacer>& pacer) {
    summary["missed_deadlines"] = pacer ? pacer->missed_deadlines() : 0;
    if (pacer) summary["worst_lag_ms"] = Milliseconds(pacer->worst_lag()).count();
}

Summary summary_of(const HandNode& node) {
    const HandNode::Report report = node.report();
    Summary summary;
    add_progress(summary, "hand", node.plan().scene, node.at());
    summary["sessions"] = report.sessions;
    summary["broken_sessions"] = report.broken_sessions;
    summary["interrupted_sessions"] = report.interrupted_sessions;
    summary["refused_peers"] = report.refused_peers;
    summary["events"] = report.received.events;
    summary["packets"] = report.received.packets;
    summary["late_packets"] = report.received.late;
    summary["stale_packets"] = report.received.stale;
    summary["gaps"] = report.received.gaps;
    summary["lost_events"] = report.received.lost_events;
    add_link(summary, report.link);
    summary["feed_bytes"] = report.feed_bytes;
    summary["freezes"] = report.freezes;
    summary["safe_states"] = report.safe_states;
    add_left_out(summary, node.plan().scene, node.grip().last_step.estimate);
    summary["force_error_rms_n"];
    summary["force_error_max_n"];
    add_pace(summary, node.pacer());
    if (node.pacer()) {
        const GripReport::Lateness& late = node.grip().step_lateness;
        summary["real_time_priority"] = report.real_time_priority;
        summary["step_lateness_p50_ms"] = Milliseconds(late.p50).count();
        summary["step_lateness_p99_ms"] = Milliseconds(late.p99).count();
        summary["step_lateness_max_ms"] = Milliseconds(late.max).count();
    }
    if (report.hand) add_hand_on_line(summary["hand"], *report.hand);
    summary["dropped_packets"] = report.dropped_packets;
    summary["dropped_scans"] = report.dropped_scans;
    summary["unwritten_steps"] = report.unwritten_steps;
    add_live_events(summary, node.plan().scene.output, report.lost_events);
    for (const std::string& sentence : node.said_of_emg()) summary["notes"].push_back(sentence);
    return summary;
}

Summary status_of(const HandNode& node) {
    const HandNode::Report report = node.report();
    Summary status = standing(node.plan().scene, node.at(), node.session(), report.sessions);
    status["packets"] = report.received.packets;
    status["events"] = report.received.events;
    status["bytes"] = report.link.bytes_received;
    status["gaps"] = report.received.gaps;
    status["lost_events"] = report.received.lost_events;
    status["late_packets"] = report.received.late;
    status["stale_packets"] = report.received.stale;
    status["checksum_failures"] = report.link.checksum_failures;
    status["refused_frames"] = report.link.refused_frames;
    status["forged_datagrams"] = report.link.forged_datagrams;
    status["grip_state"] = name(report.state);
    if (!report.reason.empty()) status["reason"] = report.reason;
    const GripStep& step = node.grip().last_step;
    status["force_n"] = step.estimate.force_n;
    status["sigma_n"] = step.estimate.sigma_n;
    status["doubt"] = name(step.estimate.doubt);
    status["gain"] = step.gain;
    add_left_out(status, node.plan().scene, step.estimate);
    return status;
}

namespace {

void add_chip(Summary& summary, const ChipReader* chip) {
    if (!chip) return;
    const ChipReport report = chip->report();
    Summary& of_chip = summary["chip"];
    of_chip["beginnings"] = report.beginnings;
    of_chip["packets"] = report.packets;
    of_chip["gaps"] = report.gaps;
    of_chip["lost_events"] = report.lost_events;
    of_chip["late_events"] = report.late_events;
    of_chip["refused_packets"] = report.refused_packets;
    of_chip["unknown_packets"] = report.unknown_packets;
    of_chip["implausible_packets"] = report.implausible_packets;
    of_chip["checksum_failures"] = report.frames.checksum_failures;
    of_chip["refused_frames"] = report.frames.refused + report.refused_bytes;
    of_chip["clock_jumps"] = report.clock_jumps;
    of_chip["clock_ppm"] = report.clock_ppm;
    if (!report.comparison) return;
    Summary& compared = of_chip["comparison"];
    compared["readings"] = report.comparison->readings;
    compared["equal"] = report.comparison->equal;
    compared["chip_alone"] = report.comparison->chip_alone;
    compared["emulator_alone"] = report.comparison->emulator_alone;
    compared["not_compared"] = report.comparison->not_compared;
    compared["refused_readings"] = report.comparison->refused_readings;
}

// Of all sessions; and apart, all that is known of the neurons since they last began, if that is less.
void add_neurons(Summary& summary, const CoprocessorNode& node, const CoprocessorNode::Report& report) {
    const bool began_anew = report.times_begun > 1;
    if (began_anew) {
        summary["times_begun"] = report.times_begun;
        summary["samples"] = report.counts.samples;
        summary["events"] = report.counts.events;
        summary["packets"] = report.counts.packets;
        summary["raw_sample_bytes"] = report.counts.raw_sample_bytes;
        summary["link_bytes"] = report.counts.packet_bytes;
    }
    Summary& last = began_anew ? summary["since_last_begin"] : summary;
    add_coprocessor(last, node.link_end());
    last["link_bytes"] = report.since_begin.packet_bytes;
}

}  // namespace

Summary summary_of(const CoprocessorNode& node) {
    const CoprocessorNode::Report report = node.report();
    Summary summary;
    add_progress(summary, "coprocessor", node.plan().scene, node.at());
    summary["sessions"] = report.sessions;
    summary["broken_sessions"] = report.broken_sessions;
    summary["interrupted_sessions"] = report.interrupted_sessions;
    add_neurons(summary, node, report);
    summary["dropped_packets"] = report.link.dropped_packets;
    add_link(summary, report.link);
    add_pace(summary, node.pacer());
    add_chip(summary, node.link_end().chip());
    return summary;
}

Summary status_of(const CoprocessorNode& node) {
    const CoprocessorNode::Report report = node.report();
    Summary status = standing(node.plan().scene, node.at(), node.session(), report.sessions);
    status["samples"] = report.counts.samples;
    status["packets"] = report.counts.packets;
    status["events"] = report.counts.events;
    status["bytes"] = report.link.bytes_sent;
    status["queued_bytes"] = node.session() ? node.session()->queued_bytes() : 0;
    status["dropped_packets"] = report.link.dropped_packets;
    status["bytes_received"] = report.link.bytes_received;
    status["refused_frames"] = report.link.refused_frames;
    status["hand_gain"] = report.hand_gain;
    return status;
}

Summary summary_of(const Run& run, TimePoint end, const ForceError& error,
                   const std::optional<Pacer>& pacer) {
    Summary summary;
    summary["scene"] = run.plan().scene.name;
    summary["seed"] = run.plan().scene.seed;
    summary["duration_s"] = seconds(end);
    summary["interrupted"] = end < run.plan().scene.end();
    summary["samples"] = run.coprocessor().samples();
    summary["clipped_samples"] = run.source() ? run.source()->clipped() : 0;
    summary["late_scans"] = run.coprocessor().coprocessor().late_scans();
    add_overdue(summary, run.coprocessor());
    summary["events"] = run.coprocessor().events();
    add_forms(summary, run.coprocessor().coprocessor());
    add_bus(summary, run.coprocessor().bus());
    summary["packets"] = run.packets();
    summary["link_bytes"] = run.link_bytes();
    if (run.acknowledgement_bytes() > 0) summary["acknowledgement_bytes"] = run.acknowledgement_bytes();
    if (const Channel* channel = run.channel()) {
        const PacketCounts received = run.received();
        summary["channel_lost"] = channel->counts().lost;
        summary["channel_dropped"] = channel->counts().dropped;
        summary["gaps"] = received.gaps;
        summary["lost_events"] = received.lost_events;
        summary["late_packets"] = received.late;
        summary["stale_packets"] = received.stale;
        summary["out_of_order_packets"] = received.out_of_order;
        summary["checksum_failures"] = run.checksum_failures();
        summary["safe_state"] = run.safe_reason();
    }
    summary["raw_sample_bytes"] = run.coprocessor().raw_sample_bytes();
    if (run.hand()) add_left_out(summary, run.plan().scene, run.hand()->last_step().estimate);
    summary["force_error_rms_n"] = or_null(error.rms_n());
    summary["force_error_max_n"] = or_null(error.max_n());
    add_live_events(summary, run.plan().scene.output, run.lost_by_outputs().events);
    add_pace(summary, pacer);
    add_notes(summary, run.source(), run.hand());
    return summary;
}

Summary summary_of(const Replay& replay, double from_s, const ForceError& error,
                   const std::vector<scene::Output>& outputs) {
    const ReplayCounts counts = replay.counts();
    Summary summary;
    summary["side"] = "replay";
    summary["scene"] = replay.plan().scene.name;
    summary["seed"] = replay.plan().scene.seed;
    summary["from_s"] = from_s;
    summary["until_s"] = seconds(replay.now());
    summary["closed"] = replay.closed();
    summary["sessions"] = counts.sessions;
    summary["events"] = counts.events;
    summary["packets"] = counts.packets;
    summary["late_packets"] = counts.late;
    summary["out_of_order_packets"] = counts.out_of_order;
    summary["refused_packets"] = counts.refused;
    summary["gaps"] = counts.gaps;
    summary["lost_events"] = counts.lost_events;
    summary["freezes"] = counts.freezes;
    summary["safe_states"] = counts.safe_states;
    add_left_out(summary, replay.plan().scene, replay.last_estimate());
    add_live_events(summary, outputs, replay.lost_by_outputs().events);
    summary["force_error_rms_n"] = or_null(error.rms_n());
    summary["force_error_max_n"] = or_null(error.max_n());
    return summary;
}

}  // namespace afferent
