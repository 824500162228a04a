// Runs a scene's hand on its link, with a motor of one's own: beside it, `afferent coprocessor SCENE`.
#include <afferent/nodes/hand_node.hpp>
#include <boost/asio/io_context.hpp>
#include <cstdio>

using namespace afferent;

int fail(const std::string& text) { return std::fprintf(stderr, "%s\n", text.c_str()), 1; }

int main(int, char** argv) {
    NodeOptions options;
    options.motor = [](const ControllerStep& step) {  // -1 opens, 1 closes
        std::printf("%.3f s: command %.3f at %.2f N\n", seconds(step.time), step.command,
                    step.estimate.force_n);
    };
    Observer observer;
    observer.session = [](const std::string& text) { fail(text); };
    observer.safe = [](const std::string& reason) { fail("safe state: " + reason); };

    boost::asio::io_context io;
    auto opened = HandNode::open(Scene::from_file(argv[1]), io, options, std::move(observer));
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
