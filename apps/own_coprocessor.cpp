#include "afferent/apps/own_coprocessor.hpp"

#include <chrono>

#include "afferent/apps/event_loop.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/print_at_once.hpp"
#include "afferent/nodes/coprocessor_end.hpp"
#include "afferent/nodes/coprocessor_node.hpp"
#include "afferent/nodes/real_time.hpp"

namespace afferent {

namespace {

void tell_comparison(const CoprocessorNode& node) {
    const ChipReader* const chip = node.link_end().chip();
    if (!chip) return;
    const auto counts = chip->report().comparison;
    if (!counts) return;
    say("the chip: " + std::to_string(counts->equal) + " events equal to the emulator's, " +
        std::to_string(counts->chip_alone) + " of the chip alone, " + std::to_string(counts->emulator_alone) +
        " of the emulator alone, " + std::to_string(counts->not_compared) + " not compared");
}

}  // namespace

OwnCoprocessor::OwnCoprocessor(const Scene& scene) : thread_([this, &scene] { run(scene); }) {
    give_real_time_priority(thread_);
}

OwnCoprocessor::~OwnCoprocessor() {
    ends_.store(true, std::memory_order_relaxed);
    thread_.join();
}

void OwnCoprocessor::run(const Scene& scene) {
    constexpr std::chrono::milliseconds pause{200};
    std::string told;
    while (!ends_.load(std::memory_order_relaxed)) {
        EventLoop loop;
        Observer observer;
        // What the hand says of the session, a person need not read twice; what a chip is about, nobody else
        // says.
        if (std::holds_alternative<scene::Chip>(scene.source))
            observer.session = [](const std::string& text) { say("the coprocessor: " + text); };
        auto node = CoprocessorNode::open(scene, loop.io(), {}, std::move(observer));
        if (node) {
            node.value()->start();
            loop.run([&] {
                if (ends_.load(std::memory_order_relaxed)) node.value()->interrupt();
                return node.value()->poll();
            });
        }
        if (node) tell_comparison(*node.value());
        if (ends_.load(std::memory_order_relaxed)) return;
        const auto& failure = node ? node.value()->failure() : std::optional(node.error().text);
        if (failure && *failure != told) say("the coprocessor: " + *failure);
        told = failure.value_or("");
        std::this_thread::sleep_for(pause);
    }
}

}  // namespace afferent
