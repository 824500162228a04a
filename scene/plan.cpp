#include "afferent/scene/plan.hpp"

#include <algorithm>
#include <thread>

#include "afferent/decoders/afferent_builder.hpp"
#include "afferent/decoders/interval_drive.hpp"
#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/packetizer.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "afferent/scene/part_plans.hpp"
#include "afferent/scene/plan_bounds.hpp"
#include "afferent/scene/readout_plans.hpp"
#include "afferent/scene/scene_faults.hpp"
#include "afferent/scene/scene_table.hpp"

namespace afferent {
namespace {

// A window of fewer neurons than this is over before another thread has woken up.
constexpr std::uint32_t neurons_per_thread = 4096;
// The same for any number of threads, because a shard decides on its form by itself. As many as a sweep takes
// through the cache at a time.
constexpr std::uint32_t afferents_per_shard = 1024;

std::size_t threads_for(const Scene& scene, std::uint32_t addresses) {
    if (scene.runtime.threads > 0) return scene.runtime.threads;
    const std::size_t processors = std::max(1U, std::thread::hardware_concurrency());
    return std::clamp<std::size_t>(addresses / neurons_per_thread, 1, processors);
}

std::vector<Plan::ShardPlan> shards_of(const Plan& plan) {
    std::vector<Plan::ShardPlan> shards;
    for (std::size_t i = 0; i < plan.patches.size(); ++i)
        for (std::uint32_t begin = 0; begin < plan.patches[i].afferents(); begin += afferents_per_shard)
            shards.push_back({i, begin, std::min(afferents_per_shard, plan.patches[i].afferents() - begin)});
    return shards;
}

Encoding wire_encoding(scene::Encoding encoding) {
    switch (encoding) {
        case scene::Encoding::rice:
            return Encoding::rice;
        case scene::Encoding::fixed_width:
            return Encoding::fixed_width;
        case scene::Encoding::predicted:
            return Encoding::predicted;
    }
    return Encoding::rice;
}

std::vector<NeuronGroup> neuron_groups(const Plan& plan) {
    std::vector<NeuronGroup> groups;
    for (const PatchPlan& patch : plan.patches)
        groups.push_back({patch.afferents(), neuron_law(patch.neuron)});
    return groups;
}

// A packet, or a scan of the hand's samples, has to fit into one datagram.
void check_datagrams(const Plan& plan) {
    const std::string limit = std::to_string(max_datagram_frame_bytes) + " bytes, which a datagram holds";
    require(most_packet_bytes(*plan.packets) <= max_datagram_frame_bytes, "packet_events",
            ("so few that a packet takes at most " + limit).c_str(), plan.packets->max_events);
    constexpr std::size_t framing_bytes = 64;
    if (plan.samples_from == SamplesFrom::hand)
        require(framing_bytes + plan.elements * sizeof(double) <= max_datagram_frame_bytes, "elements",
                ("so few that the hand's samples take at most " + limit).c_str(), plan.elements);
}

DecodedAfferents decoded_afferents(const Plan& plan) {
    DecodedAfferents afferents;
    AfferentBuilder builder(afferents);
    afferents.addresses = plan.addresses;
    afferents.uncertainty = plan.scene.uncertainty;
    if (plan.packets) afferents.tick = plan.timing.tick + 2 * plan.packets->tolerance;
    for (const PatchPlan& patch : plan.patches) {
        if (!is_read(plan.scene, patch)) continue;
        const auto body = static_cast<std::uint32_t>(patch.reads);
        afferents.hysteresis = std::max(afferents.hysteresis, patch.sensor.hysteresis);
        afferents.scan = std::max(afferents.scan, patch.scan_interval);
        afferents.delay = std::max(afferents.delay, patch.delay());
        for (std::uint32_t i = 0; i < patch.afferents(); ++i) {
            const double share = patch.share_of(i);
            builder.add(patch.first + i, decoded_group(patch, i, share, patch.largest_share_of(i)), share,
                        body);
        }
        // The grip force at which the strongest loaded element is at its full scale.
        for (const double share : patch.share)
            if (share > 0)
                afferents.largest_grip_n =
                    std::max(afferents.largest_grip_n, patch.sensor.full_scale_n / share);
    }
    return afferents;
}

ControllerPlan controller_plan(const Plan& plan) {
    const scene::Hand& hand = plan.scene.hand;
    const EmgEnvelope::Parameters of_user{hand.envelope_ms, User::rest_counts, User::full_scale_counts};
    EmgEnvelope::Parameters closing = of_user;
    if (hand.emg_table)
        closing = {hand.envelope_ms, hand.emg_table->rest_counts.value_or(User::rest_counts),
                   hand.emg_table->full_scale_counts};
    return {.decoder = decoder_parameters(plan.scene),
            .afferents = decoded_afferents(plan),
            .parts = part_plans(plan),
            .readouts = {},
            .control = {.gain = plan.scene.gain, .safe_state = hand.safe_state},
            .reflexes = reflex_parameters(plan.scene),
            .presumes = plan.packets && !(plan.packets->acknowledged && plan.packets->tolerance > 0ns),
            .emg_rate_hz = hand.emg_rate_hz,
            .closing = closing,
            .opening = of_user};
}

// What is decoded together is of one age.
void check_nerves(const Plan& plan) {
    const PatchPlan* first = nullptr;
    for (const PatchPlan& patch : plan.patches) {
        if (!is_read(plan.scene, patch)) continue;
        if (first != nullptr && patch.conduction != first->conduction)
            throw ParameterError("patch", "patches whose nerves delay events by the same time",
                                 "\"" + first->name + "\" and \"" + patch.name + "\"");
        first = &patch;
    }
}

bool estimate_is_read(const Scene& scene, Commands commands) {
    // Where afferents have places, there is a picture of them, which shows no estimate.
    const bool draws_estimate =
        scene.record.picture && std::ranges::none_of(scene.patches, [](const scene::Patch& patch) {
            return patch.outline.has_value();
        });
    return commands != Commands::unused || std::holds_alternative<scene::SimulatedHand>(scene.source) ||
           scene.record.force || draws_estimate || std::ranges::any_of(scene.output, takes_steps) ||
           asks_for_readouts(scene.decoder);
}

// What no hand moves by need not reach its limit: recordings, and what is decoded for people to read.
bool moves_hand(const Scene& scene, Commands commands) {
    if (commands == Commands::recorded) return false;
    return commands == Commands::wanted || std::holds_alternative<scene::SimulatedHand>(scene.source) ||
           std::ranges::any_of(scene.output, takes_steps);
}

void check_limit(Plan& plan, SceneFaults& faults) {
    plan.unreachable_limit = unreachable_limit(plan.controller->gain_loop());
    if (plan.unreachable_limit.empty() || plan.scene.gain.accept_unreachable_limit) return;
    faults.add({"gain.limit_n", "",
                "gain." + plan.unreachable_limit +
                    ". Give it a limit that it can reach, or accept that with gain { "
                    "accept_unreachable_limit: true }"});
}

// Decides everything but what is only for people to read. The plan is of no use if there are faults.
Plan decide(const Scene& scene, Commands commands, SceneFaults& faults) {
    Plan plan{};
    plan.scene = scene;
    if (!check_ranges(scene, faults)) return plan;
    check_scene(scene, faults);
    plan.patches = plan_patches(scene, faults);
    if (!faults.none()) return plan;
    for (const PatchPlan& patch : plan.patches) {
        plan.addresses += patch.afferents();
        if (patch.owns_elements) plan.elements += patch.elements();
    }
    check_hand_sensors(plan, faults);
    plan.threads = threads_for(scene, plan.addresses);
    if (const auto after_ms = scene.runtime.skip_scans_after_ms)
        plan.skip_scans_after = from_milliseconds(*after_ms);
    if (traits_of(scene.source).emulated) plan.shards = shards_of(plan);
    plan.samples_from = traits_of(scene.source).from;
    plan.timing = link_timing(scene.link);
    const TransportTraits transport = traits_of(scene.link.transport);
    plan.over_datagrams = transport.datagrams;
    if (scene.link.bus) {
        plan.bus = {.addresses = plan.addresses,
                    .cycle = Duration(scene.link.bus->cycle_ns),
                    .rows = scene.link.bus->rows,
                    .row_events = scene.link.bus->row_events};
        faults.check("link.bus", "", [&] { plan.bus->check(); });
    }
    if (transport.packets) {
        plan.packets = packet_layout(plan);
        faults.check("link", "", [&] {
            plan.packets->check();
            if (plan.over_datagrams) check_datagrams(plan);
        });
    }
    if (std::holds_alternative<scene::SimulatedHand>(scene.source))
        plan.gripper = gripper_parameters(scene.hand);
    if (estimate_is_read(scene, commands)) {
        faults.check("decoder", "", [&] { check_nerves(plan); });
        plan.controller = controller_plan(plan);
        faults.check("decoder", "",
                     [&] { (void)make_decoder(plan.controller->decoder, plan.controller->afferents); });
        if (!plan.controller->parts.empty())
            faults.check("decoder.parts", "", [&] { (void)make_part_decoders(*plan.controller); });
        faults.check("decoder", "", [&] { plan.controller->readouts = readout_plans(plan); });
        if (faults.none() && moves_hand(scene, commands)) check_limit(plan, faults);
    }
    return plan;
}

void add_runtime_items(const Plan& plan, PlanItems& items) {
    const scene::Record& record = plan.scene.record;
    items.add("recording of events", record.events, "record.events");
    items.add("recording of force", record.force, "record.force");
    items.add("picture", record.picture, "record.picture");
    items.add("skipping of overdue scans", plan.skip_scans_after.has_value(),
              plan.skip_scans_after
                  ? "runtime.skip_scans_after_ms: in real time, when " +
                        decimal(Milliseconds(*plan.skip_scans_after).count()) + " ms behind the clock"
                  : "in real time, everything is computed, however late");
    items.add("worker threads", plan.threads > 1,
              plan.threads > 1
                  ? "the scene is worth " + std::to_string(plan.threads) + " threads"
                  : std::to_string(plan.addresses) + " neurons are less work than waking a thread");
}

std::vector<PlanItem> items_of(const Plan& plan) {
    PlanItems items;
    for (const PatchPlan& patch : plan.patches) add_items(patch, plan, items);
    items.add("address-event bus", plan.bus.has_value(),
              plan.bus ? "link.bus: at most " + decimal(1 / seconds(plan.bus->cycle)) +
                             " events per second, of " + std::to_string(plan.bus->rows) + " rows"
                       : "events reach the link as they are fired");
    add_source_items(plan, items);
    add_link_items(plan, items);
    add_decoder_items(plan, items);
    add_output_items(plan, items);
    add_hand_items(plan, items);
    add_runtime_items(plan, items);
    return items.take();
}

}  // namespace

NeuronLaw neuron_law(const NeuronModel& neuron) {
    const LifParameters& lif = lif_of(neuron);
    return {.tau_m_ms = lif.tau_m_ms,
            .tau_g_ms = lif.tau_g_ms,
            .v_r_mv = lif.v_r_mv,
            .v_th_mv = lif.v_th_mv,
            .e_k_mv = lif.e_k_mv,
            .delta_g = lif.delta_g,
            .refractory_ms = lif.refractory_ms};
}

PacketLayout packet_layout(const Plan& plan) {
    return {.addresses = plan.addresses,
            .tick = plan.timing.tick,
            .span = plan.timing.span,
            .gathered_spans = static_cast<std::uint32_t>(plan.timing.packet / plan.timing.span),
            .heartbeat = plan.timing.heartbeat,
            .encoding = wire_encoding(plan.scene.link.encoding),
            .max_events = plan.scene.link.packet_events,
            .tolerance = from_milliseconds(plan.scene.link.timing_tolerance_us / 1e3),
            .acknowledged = plan.scene.link.encoding == scene::Encoding::predicted && plan.may_lose_packets(),
            .neurons = plan.scene.link.encoding == scene::Encoding::predicted ? neuron_groups(plan)
                                                                              : std::vector<NeuronGroup>()};
}

std::vector<SceneFault> faults_of(const Scene& scene) {
    SceneFaults faults;
    (void)decide(scene, Commands::unused, faults);
    return faults.all();
}

Plan make_plan(const Scene& scene, Commands commands) {
    SceneFaults faults;
    Plan plan = decide(scene, commands, faults);
    if (!faults.none()) {
        std::vector<std::string> messages;
        for (const SceneFault& fault : faults.all()) messages.push_back(fault.path + ": " + fault.message());
        throw SceneError(std::move(messages));
    }
    // A long table takes a while to read, so that a scene is checked without it.
    if (!scene.duration_s) plan.scene.duration_s = default_duration_s(scene);
    add_bounds(plan);
    plan.items = items_of(plan);
    return plan;
}

}  // namespace afferent
