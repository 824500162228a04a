#include "afferent/view/view.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "afferent/engine/controller.hpp"
#include "afferent/engine/coprocessor.hpp"
#include "afferent/scene/plan.hpp"
#include "tests/value_or_throw.hpp"
#include "tests/view/client.hpp"

namespace afferent {
namespace {

using Json = nlohmann::json;

Plan plan_of_nine() {
    return make_plan(
        Scene::from_text("name: \"nine\" patch { name: \"thumb\" elements: 9 } source { pushed {} } "
                         "hand { emg_rate_hz: 200 }"),
        Commands::wanted);
}

struct Computed {
    std::vector<double> estimates_n;
    std::uint64_t events = 0;
};

// A grasp of that long, as fast as it goes; the view, if there is one, is told everything.
Computed compute(const Plan& plan, View* view, Duration duration) {
    Coprocessor coprocessor(plan);
    Controller controller(plan);
    Computed computed;
    const TimePoint end = scene_start + duration;
    for (TimePoint now = scene_start; now < end; now += 5ms) {
        const std::vector<double> forces_n(9, 1 + seconds(now - scene_start) / 10);
        coprocessor.push({now, 0, forces_n});
        const auto events = coprocessor.advance(now + 5ms - 1ns);
        computed.events += events.size();
        controller.observe(now, now + 5ms, events);
        const ControllerStep& step =
            controller.step(now + 5ms, {.closing_counts = 2300, .opening_counts = 2048});
        computed.estimates_n.push_back(step.estimate.force_n);
        if (!view) continue;
        view->feed().events(events);
        view->feed().silent_until(now);
        view->feed().step(step);
        view->feed().link(MonotonicTime(now.time_since_epoch()), [&] {
            return LinkState{.time = now, .session = "open", .events = computed.events, .grip = "operating"};
        });
    }
    if (view) {
        view->feed().steps_end();
        view->feed().events_end();
    }
    return computed;
}

std::uint64_t events_of(const Json& portion) {
    std::uint64_t sum = 0;
    for (const Json& run : portion.at("raster"))
        for (const Json& count : run.at("counts")) sum += count.get<std::uint64_t>();
    return sum;
}

TEST(View, TellsItsViewersWhatTheSceneDoes) {
    const Plan plan = plan_of_nine();
    auto view = value_or_throw(View::open(plan, {.command = "test"}));
    ViewClient client(view->url());
    ASSERT_TRUE(client.open());
    const auto hello = Json::parse(client.message().value());
    EXPECT_EQ(hello.at("kind"), "hello");
    EXPECT_EQ(hello.at("version"), 1);
    EXPECT_EQ(hello.at("scene"), "nine");
    EXPECT_EQ(hello.at("command"), "test");
    EXPECT_EQ(hello.at("limit_n"), plan.scene.gain.limit_n);
    EXPECT_EQ(hello.at("raster").at("rows"), 9);
    EXPECT_GT(hello.at("raw_bytes_per_s"), 200 * 9 * 12 / 8.0);

    const Computed computed = compute(plan, view.get(), 2s);
    view.reset();
    std::uint64_t events = 0;
    std::vector<double> estimates;
    std::vector<double> times;
    std::set<std::string> doubts;
    Json link;
    for (Json message; message["kind"] != "end";) {
        const auto text = client.message();
        ASSERT_TRUE(text);
        message = Json::parse(*text);
        if (message["kind"] != "update") continue;
        EXPECT_EQ(message["unseen"], 0);
        const Json& portion = message["portion"];
        events += events_of(portion);
        for (const Json& each : portion.at("samples").at("estimate_n")) estimates.push_back(each);
        for (const Json& each : portion.at("samples").at("time_s")) times.push_back(each);
        for (const Json& each : portion.at("samples").at("true_n")) EXPECT_TRUE(each.is_null());
        for (const char* const column : {"estimate_n", "true_n", "doubt"})
            ASSERT_EQ(portion.at("samples").at(column).size(), portion.at("samples").at("time_s").size())
                << column;
        for (const Json& each : portion.at("samples").at("doubt")) doubts.insert(each.get<std::string>());
        if (!portion.at("link").is_null()) link = portion.at("link");
    }
    EXPECT_GT(events, 100U);
    EXPECT_EQ(events, computed.events);
    ASSERT_GE(estimates.size(), 100U);
    EXPECT_TRUE(doubts.contains("none"));
    for (std::size_t i = 0; i < estimates.size(); ++i)
        EXPECT_EQ(estimates[i],
                  computed.estimates_n.at(static_cast<std::size_t>(std::lround(times[i] / 5e-3)) - 1));
    EXPECT_EQ(link.at("session"), "open");
    EXPECT_EQ(link.at("grip"), "operating");
    EXPECT_TRUE(link.at("lateness_p99_ms").is_null());
}

TEST(View, HandsALateViewerTheLastMinute) {
    const Plan plan = plan_of_nine();
    auto view = value_or_throw(View::open(plan, {.command = "test"}));
    // In pieces that the rings hold, each of which the server has taken before the next.
    Computed computed;
    for (int piece = 0; piece < 15; ++piece) {
        for (int i = 0; i < 250; ++i) {
            ViewSample sample{.time = scene_start + (piece * 250 + i) * 20ms};
            sample.estimate_n = piece * 250 + i;
            view->feed().sample(sample);
            const Event event{sample.time, 3};
            view->feed().events({&event, 1});
        }
        view->feed().steps_end();
        ViewClient client(view->url());
        ASSERT_TRUE(client.open());
        Json last = Json::parse(client.message().value())["portion"]["samples"]["estimate_n"];
        while (last.empty() || last.back() != piece * 250 + 249) {
            const Json message = Json::parse(client.message().value());
            last = message.at("portion").at("samples").at("estimate_n");
        }
    }
    ViewClient late(view->url());
    ASSERT_TRUE(late.open());
    const auto portion = Json::parse(late.message().value())["portion"];
    ASSERT_GT(portion.at("samples").at("estimate_n").size(), 1000U);
    ASSERT_EQ(portion.at("samples").at("time_s").size(), portion.at("samples").at("estimate_n").size());
    EXPECT_EQ(portion.at("samples").at("estimate_n").back(), 15 * 250 - 1);
    const double span_s = portion.at("samples").at("time_s").back().get<double>() -
                          portion.at("samples").at("time_s").front().get<double>();
    EXPECT_DOUBLE_EQ(span_s, 60);
    EXPECT_NEAR(static_cast<double>(events_of(portion)), 3000, 5);  // but for a span at either end
}

TEST(View, SaysThatTheSceneHasEndedWhileItStays) {
    auto view = value_or_throw(View::open(plan_of_nine(), {.command = "test"}));
    ViewClient client(view->url());
    ASSERT_TRUE(client.open());
    EXPECT_EQ(Json::parse(client.message().value())["ended"], false);
    view->feed().sample({.time = scene_start + 1s});
    view->feed().steps_end();
    view->end();
    EXPECT_EQ(Json::parse(client.message().value())["kind"], "update");
    EXPECT_EQ(Json::parse(client.message().value())["kind"], "end");
    ViewClient late(view->url());
    ASSERT_TRUE(late.open());
    EXPECT_EQ(Json::parse(late.message().value())["ended"], true);
}

TEST(View, BeginsACourseAnewForEveryViewer) {
    const Plan plan = plan_of_nine();
    auto view = value_or_throw(View::open(plan, {.command = "test"}));
    ViewClient client(view->url());
    ASSERT_TRUE(client.open());
    const auto first = Json::parse(client.message().value());
    view->feed().sample({.time = scene_start + 100s});
    view->feed().steps_start_over();
    view->feed().events_start_over();
    view->feed().sample({.time = scene_start + 1s});
    view->feed().steps_end();
    Json message;
    while (message["kind"] != "hello") message = Json::parse(client.message().value());
    EXPECT_NE(message["course"], first.at("course"));
    EXPECT_EQ(message["portion"]["samples"]["time_s"], Json::array({1.0}));
}

// What runs the scene does not notice a viewer that has stopped, and memory stays bounded: everything is
// computed, and what the rings and the viewer's queue do not hold is dropped.
TEST(View, LetsNoStoppedViewerHoldUpTheScene) {
    const Plan plan = plan_of_nine();
    const Computed alone = compute(plan, nullptr, 100s);
    EXPECT_GT(alone.events, 1000U);
    auto view = value_or_throw(View::open(plan, {.command = "test"}));
    ViewClient stopped(view->url());
    ASSERT_TRUE(stopped.open());
    ASSERT_TRUE(comes_to_pass([&] { return view->viewers() == 1; }));
    const Computed viewed = compute(plan, view.get(), 100s);
    EXPECT_EQ(viewed.estimates_n, alone.estimates_n);
    EXPECT_EQ(viewed.events, alone.events);
    view.reset();  // ends, although the viewer still takes nothing
}

}  // namespace
}  // namespace afferent
