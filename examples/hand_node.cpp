// Runs a scene's hand on its link, with a motor of one's own: beside it, `afferent coprocessor SCENE`.
#include <afferent/io/links/transports.hpp>
#include <afferent/nodes/hand_node.hpp>
#include <afferent/nodes/hello.hpp>
#include <boost/asio/io_context.hpp>
#include <cstdio>

using namespace afferent;

int fail(const std::string& text) { return std::fprintf(stderr, "%s\n", text.c_str()), 1; }

int main(int, char** argv) {
    const Plan plan = make_plan(Scene::from_file(argv[1]), Commands::wanted);
    const auto address = address_of(plan, LinkSide::hand, false);
    if (!address) return fail(address.error().text);
    boost::asio::io_context io;
    auto listener = open_listener(io, address.value());
    if (!listener) return fail(listener.error().text);

    HandNode::Callbacks callbacks;
    callbacks.step = [](const ControllerStep& step) {  // the motor: -1 opens, 1 closes
        std::printf("%.3f s: command %.3f at %.2f N\n", seconds(step.time), step.command,
                    step.estimate.force_n);
    };
    callbacks.session = [](const std::string& text) { fail(text); };
    callbacks.safe = [](const std::string& reason) { fail("safe state: " + reason); };

    auto opened = HandNode::open(plan, std::move(listener.value()), {}, std::move(callbacks),
                                 std::chrono::steady_clock::now);
    if (!opened) return fail(opened.error().text);
    HandNode& node = *opened.value();
    node.start();
    while (const auto wake = node.poll()) {
        io.restart();
        io.run_one_until(*wake);
        io.poll();
    }
    return node.failure() ? fail(*node.failure()) : 0;
}
