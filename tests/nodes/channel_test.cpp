// A scene's channel between its two ends, in virtual time.
#include <gtest/gtest.h>

#include "afferent/nodes/channel_parameters.hpp"
#include "afferent/nodes/force_error.hpp"
#include "afferent/nodes/run.hpp"
#include "tests/nodes/whole_run.hpp"

namespace afferent {
namespace {

struct ChannelOutcome {
    std::vector<double> gains;
    std::vector<double> forces_n;
    PacketCounts received;
    ChannelCounts channel;
    std::uint64_t checksum_failures = 0;
    std::string safe_reason;
    std::uint64_t events = 0;
};

// A grasp of three seconds, over that channel.
ChannelOutcome run_through(const std::string& channel) {
    const Plan plan =
        make_plan(Scene::from_text("duration_s: 3 source { simulated_hand {} } link { tcp {} " + channel +
                                   " } hand { user { close_at_s: 0.2 } object { distance_mm: 5 } }"));
    ChannelOutcome outcome;
    const auto run =
        value_or_throw(Run::open(plan, {.events = [](auto) {},
                                        .step =
                                            [&](const ControllerStep& step) {
                                                outcome.gains.push_back(step.gain);
                                                outcome.forces_n.push_back(step.estimate.force_n);
                                            }}));
    TimePoint last = scene_start;
    while (!run->done()) {
        EXPECT_GE(run->next(), last);
        last = run->next();
        value_or_throw(run->do_next());
    }
    run->finish(plan.end());
    EXPECT_EQ(outcome.gains.size(), 3000U) << "one each millisecond";
    outcome.received = run->received();
    if (run->channel()) outcome.channel = run->channel()->counts();
    outcome.checksum_failures = run->checksum_failures();
    outcome.safe_reason = run->safe_reason();
    outcome.events = run->coprocessor().events();
    return outcome;
}

TEST(ChannelParameters, OfTheWayBackHaveRandomNumbersOfTheirOwn) {
    const Scene scene = Scene::from_text("seed: 3 link { tcp {} channel { loss: 0.25 latency_ms: 2 } }");
    EXPECT_EQ(channel_parameters(scene).seed, 3U);
    const ChannelParameters back = way_back_parameters(scene);
    EXPECT_EQ(back.loss, 0.25);
    EXPECT_EQ(back.latency, 2ms);
    EXPECT_NE(back.seed, 3U);
    EXPECT_EQ(back.seed, way_back_parameters(scene, 0).seed);
    EXPECT_NE(back.seed, way_back_parameters(scene, 1).seed);
}

TEST(SceneChannel, ThatDoesNothingChangesNothing) {
    const ChannelOutcome without = run_through("");
    const ChannelOutcome with = run_through("channel {}");
    EXPECT_EQ(with.gains, without.gains);
    EXPECT_EQ(with.forces_n, without.forces_n);
    EXPECT_EQ(with.received.events, with.events);
    EXPECT_GT(with.events, 50U);
    EXPECT_EQ(with.received.gaps, 0U);
    EXPECT_EQ(with.received.late, 0U);
}

TEST(SceneChannel, WithinTheDeliveryTimeChangesNothing) {
    EXPECT_EQ(run_through("channel { latency_ms: 1.5 }").gains, run_through("").gains);
}

TEST(SceneChannel, LaterThanTheDeliveryTimeMakesPacketsLate) {
    const ChannelOutcome late = run_through("channel { latency_ms: 12 }");
    EXPECT_GT(late.received.packets, 100U);
    EXPECT_EQ(late.received.late, late.received.packets);
    EXPECT_NE(late.gains, run_through("").gains);
}

TEST(SceneChannel, ThatReordersWithinTheDeliveryTimeLosesNothing) {
    const ChannelOutcome reordered =
        run_through("delivery_ms: 12 channel { latency_ms: 3 jitter_ms: 2 reorder: 0.3 }");
    EXPECT_GT(reordered.channel.reordered, 30U);
    EXPECT_LE(reordered.received.gaps, 1U) << "what is under way at the end";
    EXPECT_EQ(reordered.received.out_of_order, 0U);
    EXPECT_EQ(reordered.received.events, reordered.events);
    EXPECT_EQ(reordered.gains, run_through("delivery_ms: 12").gains);
}

// The filter's error with a perfect link is about 0.14 N. That of one which takes for silent what is late or
// lost, and so for released, is twice as large.
TEST(SceneChannel, ThatDelaysAndLosesDoesNotReleaseTheGrip) {
    const auto rms_n = [](const std::string& channel) {
        ForceError error;
        const std::vector<Setting> settings{Setting::from("decoder=filter"),
                                            Setting::from("link.channel={" + channel + "}")};
        whole_run(make_plan(Scene::from_file(AFFERENT_SOURCE_DIR "/examples/lossy.txtpb", settings)),
                  {.step = [&](const ControllerStep& step) {
                      error.add(step.true_force_n.value(), step.estimate.force_n);
                  }});
        return error.rms_n().value();
    };
    const double perfect_n = rms_n("");
    EXPECT_LT(rms_n("latency_ms: 1 jitter_ms: 3"), 1.1 * perfect_n);
    EXPECT_LT(rms_n("loss: 0.02"), 1.3 * perfect_n);
}

TEST(SceneChannel, AccountsForWhatItLoses) {
    const ChannelOutcome lossy = run_through(
        "channel { loss: 0.2 corrupt: 0.1 duplicate: 0.1 latency_ms: 4 jitter_ms: 3 reorder: 0.1 }");
    EXPECT_GT(lossy.received.gaps, 10U);
    EXPECT_EQ(lossy.received.events + lossy.received.lost_events, lossy.events);
    EXPECT_GT(lossy.checksum_failures, 0U);
    EXPECT_GT(lossy.received.out_of_order, 0U);
    EXPECT_EQ(lossy.safe_reason, "");
}

TEST(SceneChannel, IsTheSameForTheSameSeed) {
    const std::string channel = "channel { loss: 0.1 jitter_ms: 20 corrupt: 0.1 }";
    EXPECT_EQ(run_through(channel).gains, run_through(channel).gains);
}

TEST(SceneChannel, ThatIsCutSendsTheHandToItsSafeState) {
    const ChannelOutcome cut = run_through("channel { loss: 1 }");
    EXPECT_EQ(cut.safe_reason, "no packet for 150 ms");
    EXPECT_EQ(cut.received.packets, 0U);
    EXPECT_EQ(cut.received.lost_events, cut.events);
    // The gain is 0 from the first threshold on.
    for (std::size_t step = 61; step < cut.gains.size(); ++step) ASSERT_EQ(cut.gains[step], 0) << step;
}

TEST(SceneChannel, IsRefusedWhereItMakesNoSense) {
    for (const char* link : {"channel {}", "tcp {} channel { loss: 2 }", "tcp {} channel { jitter_ms: -1 }"})
        EXPECT_THROW(Scene::from_text("link { " + std::string(link) + " }"), SceneError) << link;
}

}  // namespace
}  // namespace afferent
