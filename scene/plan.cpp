#include "afferent/scene/plan.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/neurons/rate.hpp"
#include "afferent/scene/coprocessor.hpp"
#include "afferent/scene/form.hpp"
#include "afferent/scene/run.hpp"
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
    plan.parts.push_back(
        {"packets and codec", packets,
         packets ? "the link leaves the process" : "the link is in process: events are handed over"});
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
            frames * framing_bytes +
            packets_per_second * payload_bytes(events, static_cast<double>(layout.keys()));
        plan.resting_bytes_per_second = framing_bytes / (layout.heartbeat_spans() * seconds(layout.span));
    }
    return plan;
}

}  // namespace afferent
