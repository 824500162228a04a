// The threads of `afferent hand --view`: its loop, its writer, the link with its status service, and the
// view, which has a viewer that takes nothing; beside a coprocessor as in another process. Meant for
// ThreadSanitizer.
#include <gtest/gtest.h>

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <thread>

#include "afferent/apps/event_loop.hpp"
#include "afferent/apps/hand_results.hpp"
#include "afferent/apps/live_view.hpp"
#include "afferent/apps/status_service.hpp"
#include "afferent/io/links/transports.hpp"
#include "afferent/nodes/coprocessor_report.hpp"
#include "afferent/nodes/hello.hpp"
#include "afferent/nodes/run_summary.hpp"
#include "tests/value_or_throw.hpp"
#include "tests/view/client.hpp"

namespace afferent {
namespace {

class HandAndCoprocessor : public testing::Test {
  protected:
    HandAndCoprocessor() {
        std::string name = (std::filesystem::temp_directory_path() / "afferent-threads-XXXXXX").string();
        folder_ = ::mkdtemp(name.data());
        ::setenv("XDG_RUNTIME_DIR", folder_.c_str(), 1);
    }
    ~HandAndCoprocessor() override {
        ::unsetenv("XDG_RUNTIME_DIR");
        std::filesystem::remove_all(folder_);
    }

    Plan plan() const {
        return make_plan(
            Scene::from_text("duration_s: 1.5 record { picture: false } link { unix_socket { path: \"" +
                             (folder_ / "s.sock").string() +
                             R"(" } }
            hand { user { close_at_s: 0.1 close_for_s: 0.6 hold_for_s: 0.4 open_for_s: 0.2 effort: 0.7 }
                   object { distance_mm: 5 stiffness_n_per_mm: 1 } })"),
            Commands::wanted);
    }

    std::filesystem::path folder_;
};

void run_coprocessor(const Plan& plan) {
    EventLoop loop;
    auto connector = make_connector(loop.io(), value_or_throw(address_of(plan, LinkEnd::coprocessor, false)),
                                    {.limit = std::chrono::milliseconds(30'000)}, link_options(plan, false));
    auto node = CoprocessorNode::open(plan, std::move(connector), {}, {}, std::chrono::steady_clock::now);
    ASSERT_TRUE(node);
    const StatusService service(loop.io(), plan.scene, "coprocessor",
                                [&] { return status_of(*node.value()); });
    node.value()->start();
    loop.run([&] { return node.value()->poll(); });
    EXPECT_GT(node.value()->report().sessions, 0U);
}

TEST_F(HandAndCoprocessor, StepWriteAndTellHowTheyStandAtOnce) {
    const Plan hands = plan();
    const Plan theirs = plan();
    EventLoop loop;
    auto listener = open_listener(loop.io(), value_or_throw(address_of(hands, LinkEnd::hand, false)),
                                  link_options(hands, false));
    ASSERT_TRUE(listener) << listener.error().text;
    std::unique_ptr<HandNode> node;
    LiveView view({.view = true}, hands, "hand");
    ViewClient stopped(view.url());
    ASSERT_TRUE(stopped.open());
    HandResults output(hands, folder_ / "out", FullPipe::wait);
    Observer observer;
    observer.step = [&](const ControllerStep& step) {
        output.step(step);
        view.step(step);
    };
    observer.events = [&](std::span<const Event> events) {
        output.events(events);
        view.events(events);
    };
    observer.session = [&](const std::string& text) { view.note(node->at(), text); };
    observer.about_to_start_over = [&] { output.about_to_start_over(*node); };
    observer.starting_over = [&] { output.starting_over(); };
    auto opened =
        HandNode::open(hands, std::move(listener.value()),
                       {.record = (folder_ / "r.afferent").string(), .grip_thread = true, .writes = false},
                       std::move(observer), std::chrono::steady_clock::now);
    ASSERT_TRUE(opened) << opened.error().text;
    node = std::move(opened.value());
    output.start_thread(*node);

    std::atomic<bool> ends{false};
    int answers = 0;
    std::thread asks([&] {
        while (!ends) {
            for (const char* link_end : {"hand", "coprocessor"})
                if (const auto status = ask_status(theirs.scene, link_end); status && status->find("at_s"))
                    ++answers;
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    });
    std::thread coprocessor([&] { run_coprocessor(theirs); });
    Summary summary;
    bool written = false;
    {
        const StatusService service(loop.io(), hands.scene, "hand", [&] { return status_of(*node); });
        node->start();
        loop.run([&] {
            view.look_at(*node);
            return node->poll();
        });
        summary = summary_of(*node);
        written = output.finish(*node, summary);
        view.finish();
    }
    ends = true;
    asks.join();
    coprocessor.join();
    EXPECT_TRUE(written);
    EXPECT_FALSE(output.failure()) << *output.failure();
    EXPECT_GT(summary.find("events")->number().value_or(0), 10);
    EXPECT_GT(answers, 2);
    EXPECT_TRUE(std::filesystem::exists(folder_ / "out/force.csv"));
    EXPECT_TRUE(std::filesystem::exists(folder_ / "r.afferent"));
    // Before the node that its thread writes for.
    EXPECT_EQ(output.draw_pictures().size(), 0U);
}

}  // namespace
}  // namespace afferent
