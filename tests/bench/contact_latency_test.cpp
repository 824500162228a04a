// The contact's latency is that of the trial, for each decoder, beside the plan's budget.
#include "bench/contact_latency.hpp"

#include <gtest/gtest.h>

#include "afferent/studies/trial/experiment.hpp"
#include "afferent/studies/trial/tally.hpp"

namespace afferent {
namespace {

TEST(ContactLatency, IsTheTrialsForEachDecoderAndForAPromptChain) {
    Scene scene = Scene::from_file(AFFERENT_SOURCE_DIR "/examples/trial_in_hand.txtpb");
    for (scene::Patch& patch : scene.patches) patch.sensor.rate_hz = 200;
    scene.link.prompt_ms.reset();
    double done = 0;
    const auto rows = bench::measure_contact_latency(scene, 12, [&](double fraction) {
        EXPECT_GT(fraction, done);
        done = fraction;
    });
    EXPECT_EQ(done, 1);
    ASSERT_EQ(rows.size(), 12U);
    const Tally force = tally(Experiment(scene, "force").present(0, 12)).delicate;
    EXPECT_EQ(rows[0].condition, "force");
    EXPECT_EQ(rows[0].answered, force.answers());
    EXPECT_EQ(rows[0].median_ms, 1e3 * force.answer_s(0.5).value());
    for (std::size_t i = 0; i < 6; ++i) {
        SCOPED_TRACE(rows[i].condition);
        EXPECT_EQ(rows[i].condition, rows[i + 6].condition);
        // Sampling, packet, delivery and step: 5 + 5 + 2 + 1, and 1 + 1 + 2 + 1.
        EXPECT_EQ(rows[i].budget_ms, 13);
        EXPECT_EQ(rows[i + 6].budget_ms, 5);
        EXPECT_LT(rows[i + 6].median_ms.value(), rows[i].median_ms.value());
        EXPECT_LE(rows[i].told_median_ms.value(), rows[i].median_ms.value());
        EXPECT_EQ(rows[i].chain, "the scene's");
        EXPECT_EQ(rows[i + 6].chain, "1 kHz, prompt_ms 1");
    }
    EXPECT_EQ(rows[0].told_median_ms, 1e3 * force.told_s(0.5).value());
}

TEST(ContactLatency, ComparesAPromptSceneWithOneThatIsNot) {
    const Scene scene = Scene::from_file(AFFERENT_SOURCE_DIR "/examples/trial_in_hand.txtpb");
    const auto rows = bench::measure_contact_latency(scene, 4, [](double) {});
    ASSERT_EQ(rows.size(), 12U);
    EXPECT_EQ(rows[0].budget_ms, 5);
    EXPECT_EQ(rows[6].budget_ms, 13);
    EXPECT_EQ(rows[6].chain, "200 Hz, no prompt_ms");
}

}  // namespace
}  // namespace afferent
