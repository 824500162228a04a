// What a scene needs: decided once, carried out by whoever puts the scene together.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "afferent/hand/gripper.hpp"
#include "afferent/io/wire/event_bus.hpp"
#include "afferent/io/wire/packet_layout.hpp"
#include "afferent/scene/controller_plan.hpp"
#include "afferent/scene/patch_plan.hpp"
#include "afferent/scene/plan_items.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// Whether anyone besides the scene itself reads the hand's commands: a motor, or a program.
// recorded: the estimates and commands are wanted, and no hand moves by them.
enum class Commands { unused, recorded, wanted };

// Upper bounds on the delay that each stage of the chain adds between a touch and the controller's step.
// Where the link has prompt_ms, for a touch after a silence of heartbeat_ms.
struct LatencyBudget {
    Duration sampling{};  // until the element is sampled
    Duration sensor{};    // until its sample arrives, as sensor.delay_ms says
    Duration nerve{};     // from a spike until its event leaves
    Duration packet{};    // from then until its packet closes
    Duration delivery{};  // until the packet acts
    Duration step{};      // until the controller's next step
    Duration most() const noexcept { return sampling + sensor + nerve + packet + delivery + step; }
};

struct Plan {
    // The scene, checked; to be read only for names, paths and numbers. What is built is decided below.
    Scene scene;

    // Coprocessor: shards of afferents, and how many threads they are worth.
    std::vector<PatchPlan> patches;
    struct ShardPlan {
        std::size_t patch;
        std::uint32_t begin;  // of its afferents
        std::uint32_t count;
    };
    std::vector<ShardPlan> shards;
    std::size_t threads;
    std::uint32_t addresses;
    std::uint32_t elements;
    SamplesFrom samples_from;
    // Nothing: in real time, neurons that fall behind are given all scans nevertheless.
    std::optional<Duration> skip_scans_after;
    std::optional<EventBusParameters> bus;

    // Nothing: events are handed over as they are.
    std::optional<PacketLayout> packets;
    LinkTiming timing;
    // Frames may be lost, come twice, or out of order.
    bool over_datagrams;
    bool may_lose_packets() const noexcept { return over_datagrams || scene.link.channel.has_value(); }

    // Nothing: nobody reads the estimate.
    std::optional<ControllerPlan> controller;
    // Nothing: open loop.
    std::optional<Gripper::Parameters> gripper;
    // Why the gain cannot reach 0 at its limit, which the scene accepts; empty: it can, or no hand moves by
    // it.
    std::string unreachable_limit;

    // For people: what is built and what is left out, and why.
    std::vector<PlanItem> items;

    double bytes_per_neuron;   // of state, encoder and queue
    double bytes_per_element;  // the same, over elements that several neurons may read

    // An upper bound, whatever touches the sensors: every neuron fires as one that does not adapt would at
    // its full scale. Infinite where only the spike limit bounds it.
    double events_per_second;
    // Packets with as many events, framing included; 0 where the link carries none.
    double bytes_per_second;
    // For an untouched hand: heartbeats alone.
    double resting_bytes_per_second;
    // All 0 without a controller or packets, and where no bound is known: behind an event bus or a channel of
    // limited bandwidth, and where samples come at any pace. Excludes the neuron's own time to its first
    // spike, and what a real link takes beyond delivery_ms.
    LatencyBudget latency;

    bool in_process() const noexcept { return !packets; }
    TimePoint end() const { return scene.end(); }
};

Gripper::Parameters gripper_parameters(const scene::Hand& hand);

// The layout of the scene's packets, or what it would be where the link carries none.
PacketLayout packet_layout(const Plan& plan);
// What the other end of a link knows of neurons of that model.
NeuronLaw neuron_law(const NeuronModel& neuron);

// Throws SceneError, as Scene::check does.
Plan make_plan(const Scene& scene, Commands commands = Commands::unused);

}  // namespace afferent
