#include "afferent/scene/plan.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/io/wire/frame.hpp"
#include "afferent/neurons/rate.hpp"
#include "afferent/scene/coprocessor.hpp"
#include "afferent/scene/form.hpp"
#include "afferent/scene/scene_link.hpp"

namespace afferent {
namespace {

std::string number(double value) {
    std::string text = std::to_string(value);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
    return text;
}

// The highest rate of a neuron of the patch: at full scale, without adaptation.
double highest_rate_hz(const Scene& scene, const Patch& patch) {
    const Patch& owner = scene.patches()[patch.reads];
    // A clocked sensor changes by no more than its full scale from one sample to the next.
    const double input =
        patch.sustained() ? owner.sensor.full_scale_n : owner.sensor.full_scale_n * owner.rate_hz;
    NeuronParameters neuron = patch.neuron;
    neuron.delta_g = 0;
    return rate_hz(RateKind::onset, neuron, patch.gain() * input + patch.bias_mv());
}

// Rice-coded gaps of n keys out of `keys`, as io/payload.hpp writes them: log2(keys/n) + 2.5 bits for each at
// most.
double payload_bytes(double events, double keys) {
    return events > 0 ? events * (std::log2(std::max(1.0, keys / events)) + 2.5) / 8 : 0;
}

constexpr double framing_bytes = 12;  // of a packet, at most

// What the transport adds to each packet.
double transport_bytes(const proto::Link& link) {
    constexpr double tls_record = 5 + 1 + 16;  // header, kind, tag
    constexpr double cobs = 2;                 // of a short datagram
    if (link.has_tcp()) return link.has_keys() ? tls_record : 0;
    return (link.has_keys() ? static_cast<double>(longest_seal_bytes) : 0) + (link.has_serial() ? cobs : 0);
}

std::string transport_of(const proto::Link& link) {
    if (link.has_unix_socket()) return "Unix socket " + link.unix_socket().path();
    if (link.has_tcp()) return "TCP " + link.tcp().host() + ":" + std::to_string(link.tcp().port());
    if (link.has_udp()) return "UDP " + link.udp().host() + ":" + std::to_string(link.udp().port());
    if (link.has_serial())
        return "serial line " + link.serial().device() + ", " + std::to_string(link.serial().baud()) +
               " baud";
    if (link.has_file()) return "file " + link.file().path();
    return "in process";
}

void add_link_parts(const proto::Link& link, std::vector<Plan::Part>& parts) {
    const bool packets = !in_process(link);
    parts.push_back({"packets and codec", packets,
                     packets ? "the link leaves the process: " + transport_of(link)
                             : "the link is in process: events are handed over"});
    parts.push_back({"keys", link.has_keys(),
                     !link.has_keys() ? "link.keys is not given: the link does not leave the machine"
                     : link.has_tcp()
                         ? "link.keys: TLS 1.3, both certificates pinned"
                         : "link.keys: each datagram sealed with ChaCha20-Poly1305, and counted"});
    parts.push_back({"channel", link.has_channel(),
                     link.has_channel()
                         ? "link.channel is between the two sides: afferent channel, or a run's own"
                         : "link.channel is not given: nothing is lost or delayed on purpose"});
    if (!packets || link.has_file()) return;
    const LinkTiming timing = link_timing(link);
    parts.push_back({"refusal of stale packets", true,
                     "older than " + number(Milliseconds(timing.stale).count()) + " ms when they come"});
    parts.push_back({"watch for silence", true,
                     "no closing after " + number(link.freeze_ms()) + " ms, safe state after " +
                         number(link.safe_ms()) + " ms"});
}

void add_patch_parts(const Scene& scene, std::vector<Plan::Part>& parts) {
    for (std::size_t i = 0; i < scene.patches().size(); ++i) {
        const Patch& patch = scene.patches()[i];
        const std::string about = "patch \"" + patch.name + "\": ";
        parts.push_back({about + "sensors", patch.owns_elements(i),
                         patch.owns_elements(i)
                             ? std::to_string(patch.elements) + " elements"
                             : "it reads those of \"" + scene.patches()[patch.reads].name + "\""});
        parts.push_back({about + (patch.sustained() ? "sustained encoder" : "transient encoder"), true,
                         patch.sustained() ? "drive in proportion to force"
                                           : "drive in proportion to its rate of change"});
        const Form form = form_of(scene, patch);
        parts.push_back({about + (form.dense ? "neurons, by a sweep per frame" : "neurons, by prediction"),
                         true, form.reason});
        parts.push_back(
            {about + "adaptation", patch.neuron.delta_g > 0, "delta_g is " + number(patch.neuron.delta_g)});
        parts.push_back({about + "refractory period", patch.neuron.refractory_ms > 0,
                         "refractory_ms is " + number(patch.neuron.refractory_ms)});
        if (patch.owns_elements(i))
            parts.push_back({about + "noise", patch.sensor.noise_counts > 0,
                             "sensor.noise_counts is " + number(patch.sensor.noise_counts)});
    }
}

}  // namespace

Plan make_plan(const Scene& scene) {
    Plan plan{};
    const proto::Scene& description = scene.description();
    add_patch_parts(scene, plan.parts);
    const proto::Link& link = description.link();
    plan.parts.push_back({"address-event bus", link.has_bus(),
                          link.has_bus()
                              ? "link.bus: at most " + number(1e9 / link.bus().cycle_ns()) +
                                    " events per second, of " + std::to_string(link.bus().rows()) + " rows"
                              : "events reach the link as they are fired"});
    const bool packets = !in_process(scene);
    add_link_parts(link, plan.parts);
    plan.parts.push_back(
        {"decoder and gain", needs_decoder(scene),
         needs_decoder(scene) ? "the estimate is recorded or moves the hand" : "nobody reads the estimate"});
    plan.parts.push_back({"simulated motor and object", simulated_hand(scene),
                          simulated_hand(scene) ? "the samples are of the simulated hand"
                                                : "open loop: the samples come from elsewhere"});
    plan.parts.push_back(
        {"simulated user", !description.hand().has_emg_table(),
         description.hand().has_emg_table() ? "the EMG is a table" : "there is no EMG table"});
    plan.parts.push_back({"recording of events", description.record().events(), "record.events"});
    plan.parts.push_back({"recording of force", description.record().force(), "record.force"});
    plan.parts.push_back({"picture", description.record().picture(), "record.picture"});

    const Coprocessor coprocessor(scene);
    plan.threads = coprocessor.threads();
    plan.parts.push_back({"worker threads", plan.threads > 1,
                          plan.threads > 1 ? "the scene is worth " + std::to_string(plan.threads) + " threads"
                                           : std::to_string(scene.addresses()) +
                                                 " neurons are less work than waking a thread"});
    plan.neurons = scene.addresses();
    plan.elements = scene.elements();
    plan.bytes_per_neuron = static_cast<double>(coprocessor.bytes()) / scene.addresses();

    plan.bytes_per_element = static_cast<double>(coprocessor.bytes()) / scene.elements();

    for (const Patch& patch : scene.patches())
        plan.events_per_second += patch.elements * highest_rate_hz(scene, patch);
    if (packets) {
        const PacketLayout layout = packet_layout(scene);
        const double packets_per_second = 1 / seconds(layout.span);
        const double passed_per_second = link.has_bus()
                                             ? std::min(plan.events_per_second, 1e9 / link.bus().cycle_ns())
                                             : plan.events_per_second;
        const double events = passed_per_second / packets_per_second;
        const double frames = packets_per_second * std::max(1.0, std::ceil(events / layout.max_events));
        plan.bytes_per_second =
            frames * (framing_bytes + transport_bytes(link)) +
            packets_per_second * payload_bytes(events, static_cast<double>(layout.codes()));
        plan.resting_bytes_per_second =
            (framing_bytes + transport_bytes(link)) / (layout.heartbeat_spans() * seconds(layout.span));
    }
    return plan;
}

}  // namespace afferent
