#include "afferent/apps/own_coprocessor.hpp"

#include <chrono>

#include "afferent/apps/event_loop.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/print_at_once.hpp"
#include "afferent/nodes/coprocessor_node.hpp"
#include "afferent/nodes/real_time.hpp"

namespace afferent {

OwnCoprocessor::OwnCoprocessor(const Scene& scene) : thread_([this, &scene] { run(scene); }) {
    give_real_time_priority(thread_);
}

OwnCoprocessor::~OwnCoprocessor() {
    ends_.store(true, std::memory_order_relaxed);
    thread_.join();
}

void OwnCoprocessor::run(const Scene& scene) {
    constexpr std::chrono::milliseconds pause{200};
    while (!ends_.load(std::memory_order_relaxed)) {
        EventLoop loop;
        auto node = CoprocessorNode::open(scene, loop.io(), {}, {});
        if (node) {
            node.value()->start();
            loop.run([&] {
                if (ends_.load(std::memory_order_relaxed)) node.value()->interrupt();
                return node.value()->poll();
            });
        }
        if (ends_.load(std::memory_order_relaxed)) return;
        const auto& failure = node ? node.value()->failure() : std::optional(node.error().text);
        if (failure) say("the coprocessor: " + *failure);
        std::this_thread::sleep_for(pause);
    }
}

}  // namespace afferent
