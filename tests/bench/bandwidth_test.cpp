// The bandwidth benchmark measures the scene itself: its neurons, its scale, its recording.
#include "bench/bandwidth_bench.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "bench/link_activity.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

const std::string examples = AFFERENT_SOURCE_DIR "/examples/";

double sample_force_n(const LinkActivity& activity) {
    if (activity.counts.empty()) throw std::runtime_error("there are no samples");
    return static_cast<double>(std::ranges::max(activity.counts)) * activity.newtons_per_count;
}

TEST(BandwidthBench, MeasuresEveryAfferentOfAnElement) {
    const Scene scene = Scene::from_file(examples + "two_channels.txtpb");
    for (const std::uint32_t elements : {9U, 30U}) {
        const LinkActivity activity =
            grip_activity(scene, elements, "grasp", 2s, [](TimePoint time) { return 5 * seconds(time); });
        EXPECT_EQ(activity.elements, elements);
        EXPECT_EQ(activity.addresses, 2 * elements);
        ASSERT_FALSE(activity.events.empty());
        EXPECT_GT(std::ranges::max(activity.events, {}, &Event::address).address, elements);
        EXPECT_GT(measure_events(activity, 100us, 5ms, std::nullopt).bytes, activity.events.size());
    }
}

TEST(BandwidthBench, MeasuresARecordingOnItsOwnSamples) {
    Scene scene = Scene::from_file(examples + "recorded.txtpb");
    std::get<scene::Table>(scene.source).between = scene::Between::hold;
    const auto recorded = recorded_activity(scene);
    ASSERT_TRUE(recorded);
    EXPECT_EQ(recorded->scans(), 568U) << "a scan for each row of the table";
    EXPECT_NEAR(Milliseconds(recorded->frame_interval).count(), 14.08, 0.02);
    EXPECT_GT(measure_raw(*recorded, 12).bytes, recorded->scans() * 14);
    EXPECT_FALSE(recorded_activity(Scene::from_file(examples + "grasp.txtpb")));
}

// The steps of send-on-delta are shares of what an element measures, whatever the number of elements.
TEST(BandwidthBench, StepsByTheScaleOfItsElements) {
    const Scene scene = Scene::from_file(examples + "bus.txtpb");
    for (const std::uint32_t elements : {400U, 40U}) {
        const auto activity = grip_activity(scene, elements, "grasp", 500ms, [](TimePoint) { return 15; });
        const double full_scale_n = 0.1 * 400 / elements;
        EXPECT_NEAR(activity.newtons_per_count * 4095, full_scale_n, 1e-9);
        EXPECT_GT(sample_force_n(activity), 0.2 * full_scale_n);
        const auto results = measure_schemes(activity);
        std::vector<double> deltas_n;
        for (const SchemeResult& result : results)
            if (result.scheme == "send_on_delta") deltas_n.push_back(result.delta_n.value());
        ASSERT_EQ(deltas_n.size(), 3U);
        const std::array shares{0.002, 0.01, 0.05};
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(deltas_n[k], shares[k] * full_scale_n, 1e-9);
    }
}

// The table gives, for each scheme, its cost and the error of the force.
TEST(BandwidthBench, SaysHowWrongTheForceIs) {
    const Scene scene = Scene::from_file(examples + "paper.txtpb");
    const auto activity = grip_activity(
        scene, 1, "grasp", 2s, [](TimePoint time) { return 5 * std::max(0.0, seconds(time) - 0.5); });
    auto results = measure_schemes(activity);
    measure_force_errors(activity, results);
    const auto rms_n = [&](const char* scheme) {
        return found_or_throw(results, scheme, &SchemeResult::scheme).rms_n.value();
    };
    EXPECT_LT(rms_n("raw12"), 0.05);
    EXPECT_LT(rms_n("events"), 0.5);
    EXPECT_EQ(rms_n("raw12"), rms_n("delta_varint"));
    EXPECT_EQ(rms_n("raw12"), rms_n("delta_coded"));
    EXPECT_EQ(rms_n("repeated_messages"), rms_n("packed_columns"));

    auto still = measure_schemes(grip_activity(scene, 1, "rest", 1s, [](TimePoint) { return 0; }));
    measure_force_errors(poisson_activity(1, 20, 1s, 1), still);
    EXPECT_FALSE(still.at(0).rms_n) << "without a force";
}

// A regular train is known from its past: given the neuron, an event takes less than one that comes at
// random, which takes log2(e / (rate · tick)) bits.
TEST(BandwidthBench, BoundsTheCausalEntropy) {
    const Scene scene = Scene::from_file(examples + "paper.txtpb");
    const auto activity = grip_activity(scene, 1, "grasp", 4s, [](TimePoint) { return 5; });
    const auto predicted = measure_predicted(activity, 100us, 5ms, 0us);
    ASSERT_TRUE(predicted);
    const double rate_hz = static_cast<double>(activity.events.size()) / activity.seconds_long();
    // To first order in rate · tick, which is below 0.02.
    EXPECT_NEAR(predicted->poisson_bits.value(), std::log2(std::exp(1.0) / (rate_hz * 1e-4)), 0.1);
    EXPECT_LT(predicted->causal_bits.value(), 0.7 * predicted->poisson_bits.value());
    EXPECT_GT(predicted->causal_bits.value(), 0);
    // Framing and heartbeats come on top.
    EXPECT_LT(predicted->causal_bits.value() / 8 * static_cast<double>(activity.events.size()),
              static_cast<double>(predicted->bytes));
}

}  // namespace
}  // namespace afferent
