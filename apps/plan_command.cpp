// afferent plan: what is built, what is left out and why.
#include <algorithm>
#include <iomanip>
#include <iostream>
#include <memory>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/scene_options.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/nodes/coprocessor_end.hpp"
#include "afferent/nodes/hand_end.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

struct PlanOptions {
    SceneOptions scene;
    bool json = false;
};

Summary numbers(const Plan& plan) {
    Summary summary;
    summary["elements"] = plan.elements;
    summary["neurons"] = plan.addresses;
    summary["threads"] = plan.threads;
    summary["bytes_per_neuron"] = plan.bytes_per_neuron;
    summary["bytes_per_element"] = plan.bytes_per_element;
    summary["events_per_second_at_most"] = plan.events_per_second;
    summary["bytes_per_second_at_most"] = plan.bytes_per_second;
    summary["bytes_per_second_at_rest"] = plan.resting_bytes_per_second;
    if (const LatencyBudget& latency = plan.latency; latency.most() > Duration::zero()) {
        const auto ms = [](Duration duration) { return Milliseconds(duration).count(); };
        summary["latency_sampling_ms"] = ms(latency.sampling);
        summary["latency_sensor_ms"] = ms(latency.sensor);
        summary["latency_nerve_ms"] = ms(latency.nerve);
        summary["latency_packet_ms"] = ms(latency.packet);
        summary["latency_delivery_ms"] = ms(latency.delivery);
        summary["latency_step_ms"] = ms(latency.step);
        summary["latency_ms_at_most"] = ms(latency.most());
    }
    return summary;
}

void print_parts(const Plan& plan, bool built, const char* title) {
    std::size_t longest = 0;
    for (const PlanItem& part : plan.items) longest = std::max(longest, part.name.size());
    // Beside a name that is longer than this, the reason stands on a line of its own.
    const std::size_t width = std::min<std::size_t>(longest, 48) + 2;
    std::cout << title << '\n' << std::left;
    for (const PlanItem& part : plan.items) {
        if (part.built != built) continue;
        std::cout << "  " << std::setw(static_cast<int>(width)) << part.name;
        if (part.name.size() + 2 > width) std::cout << "\n  " << std::string(width, ' ');
        std::cout << part.reason << '\n';
    }
    std::cout << '\n';
}

void plan_scene(const PlanOptions& options) {
    const Plan plan = make_plan(options.scene.read_to_run());
    // What a run would open: tables that are not there, or are of other columns, are refused here as well.
    value_or_fail(CoprocessorEnd::open(plan));
    value_or_fail(HandEnd::open(plan));
    Summary summary = numbers(plan);
    if (options.json) {
        for (const PlanItem& part : plan.items)
            summary["parts"].push_back({{"name", part.name}, {"built", part.built}, {"reason", part.reason}});
        return print(summary, true);
    }
    print_parts(plan, true, "Built");
    print_parts(plan, false, "Left out");
    std::cout << "To expect\n";
    print(summary);
}

}  // namespace

Command plan_command() {
    const auto options = std::make_shared<PlanOptions>();
    return {
        .name = "plan",
        .help = "Say what a scene needs, and what is left out and why",
        .footer = "Example:\n  afferent plan examples/grasp.txtpb",
        .options = options->scene.followed_by({flag("--json", options->json, "Print the plan as JSON")}),
        .run = [options] { plan_scene(*options); },
    };
}

}  // namespace afferent
