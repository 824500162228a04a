#include "afferent/apps/side_summary.hpp"

namespace afferent {

void add_progress(Summary& summary, const char* side, const Scene& scene, TimePoint until) {
    summary["side"] = side;
    summary["scene"] = scene.description().name();
    summary["seed"] = scene.seed();
    summary["until_s"] = seconds(until);
    summary["complete"] = until >= scene_start + scene.duration();
}

void add_standing(Summary& status, const Scene& scene, TimePoint at, const Session* session,
                  std::uint64_t sessions) {
    status["scene"] = scene.description().name();
    status["at_s"] = seconds(at);
    status["session"] = !session ? "none" : session->state() == Session::State::open ? "open" : "handshake";
    status["sessions"] = sessions;
    if (session && !session->last_refusal().empty()) status["last_refusal"] = session->last_refusal();
}

void add_coprocessor(Summary& summary, const CoprocessorSide& side) {
    summary["samples"] = side.samples();
    summary["clipped_samples"] = side.source() ? Summary(side.source()->clipped()) : Summary();
    summary["late_scans"] = side.coprocessor().late_scans();
    summary["events"] = side.events();
    add_bus(summary, side.bus());
    summary["packets"] = side.packetizer()->packets();
    summary["raw_sample_bytes"] = side.raw_sample_bytes();
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

void LinkTotals::add(const Session& session) {
    const LinkCounts& link = session.counts();
    bytes_sent += link.bytes_out;
    bytes_received += link.in.bytes;
    dropped_packets += link.dropped;
    checksum_failures += link.in.checksum_failures;
    refused_frames += link.in.refused + session.refused_messages();
    forged_datagrams += link.in.forged;
    repeated_datagrams += link.in.repeated;
}

void LinkTotals::add_to(Summary& summary) const {
    summary["bytes_sent"] = bytes_sent;
    summary["bytes_received"] = bytes_received;
    summary["checksum_failures"] = checksum_failures;
    summary["refused_frames"] = refused_frames;
    summary["forged_datagrams"] = forged_datagrams;
    summary["repeated_datagrams"] = repeated_datagrams;
}

}  // namespace afferent
