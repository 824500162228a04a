// The samples that sensors take of a table, and the true force between its rows.
#include <gtest/gtest.h>

#include <cmath>

#include "afferent/nodes/emg.hpp"
#include "afferent/nodes/sample_source.hpp"
#include "afferent/nodes/table_gap.hpp"

namespace afferent {
namespace {

constexpr TimePoint at(Duration time) { return scene_start + time; }

struct Sample {
    TimePoint time;
    Address first;
    std::vector<double> forces_n;
    std::optional<double> true_n;  // at that time
};

class TableSources : public testing::Test {
  protected:
    // All scans of a table that the patches of a scene sample.
    std::vector<Sample> samples(const std::string& patches, const std::string& rows,
                                scene::Between between = scene::Between::linear,
                                scene::OutOfRange out_of_range = scene::OutOfRange::clip) {
        plan_ = make_plan(Scene::from_text(patches + " source { table { path: 'x' } }"));
        TableSource source(plan_, {.path = "x", .out_of_range = out_of_range, .between = between});
        EXPECT_TRUE(source.feed(rows));
        EXPECT_TRUE(source.finish());
        std::vector<Sample> all;
        while (const auto due = source.next()) {
            const std::optional<double> true_n = source.true_force_n(due->time);
            const auto scan = source.take(0);
            if (!scan) {
                refusal_ = source.refusal().text;
                break;
            }
            EXPECT_EQ(scan.value().time, due->time);
            all.push_back({due->time,
                           scan.value().first,
                           {scan.value().forces_n.begin(), scan.value().forces_n.end()},
                           true_n});
        }
        return all;
    }

    static std::vector<Duration> times(const std::vector<Sample>& samples) {
        std::vector<Duration> all;
        for (const Sample& sample : samples) all.push_back(sample.time - scene_start);
        return all;
    }

    Plan plan_;
    std::string refusal_;
};

constexpr const char* two_elements = "patch { name: 'a' elements: 2 sensor { rate_hz: 200 } }";

TEST_F(TableSources, SayThatMostOfTheirSamplesAreClippedAndNotThatFewAre) {
    const Plan plan =
        make_plan(Scene::from_text(std::string(two_elements) + " source { table { path: 'x' } }"));
    const auto said = [&](const std::string& rows) {
        TableSource source(plan, {.path = "x", .out_of_range = scene::OutOfRange::clip});
        EXPECT_TRUE(source.feed("time_s,force_n\n" + rows));
        EXPECT_TRUE(source.finish());
        while (source.next()) EXPECT_TRUE(source.take(0));
        EXPECT_GE(source.clipped(), 2U);
        return source.said_of_clipped();
    };
    // Five samples of two elements.
    EXPECT_EQ(said("0,1\n0.005,1\n0.01,1\n0.015,1\n0.02,-1\n"), "");
    EXPECT_EQ(said("0,-1\n0.005,-1\n0.01,-1\n0.015,-1\n0.02,1\n"),
              "8 of 10 samples are below 0, and read as 0: is the sign reversed, or the zero wrong?");
    EXPECT_EQ(said("0,1\n0.005,-1\n0.01,-1\n0.015,1e4\n0.02,1e4\n").substr(0, 35),
              "4 of 10 samples are beyond full sca")
        << "in both directions together they are most";
}

TEST_F(TableSources, EndWithTheirLastSampleAndNotBefore) {
    const Plan plan =
        make_plan(Scene::from_text(std::string(two_elements) + " source { table { path: 'x' } }"));
    TableSource source(plan, {.path = "x"});
    ASSERT_TRUE(source.feed("time_s,force_n\n0,1\n0.01,2\n0.02,3\n"));
    EXPECT_EQ(source.end(), std::nullopt);
    ASSERT_TRUE(source.finish());
    ASSERT_TRUE(source.next());
    EXPECT_EQ(source.end(), std::nullopt) << "its samples are still to be taken";
    while (source.next()) ASSERT_TRUE(source.take(0));
    EXPECT_EQ(source.end(), at(20ms));
}

TEST(TableGap, IsOneStepWhereTheRowsAreTheSamplesOrNoFartherApart) {
    const TableGap gap{.row = at(0ms), .next = at(50ms)};
    EXPECT_EQ(gap.steps(5ms, scene::Between::hold), 1);
    EXPECT_EQ(gap.steps(5ms, scene::Between::linear), 10);
    EXPECT_EQ(gap.steps(200ms, scene::Between::linear), 1);
    EXPECT_EQ(gap.step(1, 1), at(50ms));
}

TEST_F(TableSources, SampleTheLineBetweenRowsThatAreFartherApartThanSamples) {
    const auto all = samples(two_elements, "time_s,a_n,b_n\n0,0,8\n0.014,7,1\n0.030,7,5\n");
    ASSERT_EQ(times(all),
              (std::vector<Duration>{0ms, 4'666'666ns, 9'333'333ns, 14ms, 18ms, 22ms, 26ms, 30ms}))
        << "in three steps, and in four: none longer than 5 ms";
    for (const Sample& sample : all) {
        const double ms = Milliseconds(sample.time - scene_start).count();
        // To within rounding.
        EXPECT_NEAR(sample.forces_n[0], std::min(ms / 2, 7.0), 1e-12);
        EXPECT_NEAR(sample.forces_n[1], ms < 14 ? 8 - ms / 2 : 1 + (ms - 14) / 4, 1e-12);
    }
    EXPECT_EQ(all[3].forces_n, (std::vector{7.0, 1.0})) << "a row is itself, exactly";
}

TEST_F(TableSources, HoldARowUntilTheNextWhereAsked) {
    const auto all =
        samples(two_elements, "time_s,a_n,b_n\n0,0,8\n0.014,7,1\n0.030,7,5\n", scene::Between::hold);
    ASSERT_EQ(times(all), (std::vector<Duration>{0ms, 14ms, 30ms}));
    EXPECT_EQ(all[2].true_n, 8.0) << "a + b of the row before";
}

TEST_F(TableSources, SampleTheRowsWhereTheyAreNoFartherApartThanSamples) {
    const std::string rows = "time_s,a_n,b_n\n0,0,8\n0.005,7,1\n0.0105,7,2\n0.0116,7,3\n0.0217,1,1\n";
    const auto linear = samples(two_elements, rows);
    EXPECT_EQ(times(linear), (std::vector<Duration>{0ms, 5ms, 10'500us, 11'600us, 16'650us, 21'700us}))
        << "a clock that jitters by a tenth is no slower";
}

TEST_F(TableSources, HaveEachPatchSampleAtItsOwnRate) {
    const auto all = samples(
        "patch { name: 'a' elements: 1 share: 0.25 sensor { rate_hz: 100 } } patch { name: 'b' elements: 1 "
        "sensor { "
        "rate_hz: 200 } }",
        "time_s,force_n\n0,0\n0.02,4\n");
    std::vector<std::pair<Duration, Address>> order;
    for (const Sample& sample : all) order.emplace_back(sample.time - scene_start, sample.first);
    ASSERT_EQ(order,
              (std::vector<std::pair<Duration, Address>>{
                  {0ms, 0}, {0ms, 1}, {5ms, 1}, {10ms, 0}, {10ms, 1}, {15ms, 1}, {20ms, 0}, {20ms, 1}}));
    // Half a count of the converter is 0.0012 N.
    EXPECT_NEAR(all[3].forces_n[0], 0.25 * 2, 0.0013);
    EXPECT_NEAR(all[4].forces_n[0], 0.75 * 2, 0.0013);
    EXPECT_EQ(all[4].true_n, 2.0);
}

TEST_F(TableSources, KnowTheTrueForceBetweenSamplesAndHoldTheLast) {
    plan_ = make_plan(Scene::from_text(std::string(two_elements) + " source { table { path: 'x' } }"));
    TableSource source(plan_, {.path = "x"});
    ASSERT_TRUE(source.feed("time_s,force_n\n0,1\n0.02,5\n"));
    ASSERT_TRUE(source.finish());
    while (source.next() && source.next()->time < at(7ms)) ASSERT_TRUE(source.take(0));
    EXPECT_DOUBLE_EQ(source.true_force_n(at(6ms)).value(), 2.2);
    while (source.next()) ASSERT_TRUE(source.take(0));
    EXPECT_EQ(source.true_force_n(at(1s)), 5.0);
}

TEST_F(TableSources, TellEachPartItsOwnTrueForce) {
    for (const bool by_grip : {true, false}) {
        plan_ =
            make_plan(Scene::from_text("patch { name: 'a' elements: 2 share: [0.5, 0.25] } decoder { parts: "
                                       "ELEMENTS } source { table { path: 'x' } }"));
        TableSource source(plan_, {.path = "x"});
        ASSERT_TRUE(
            source.feed(by_grip ? "time_s,force_n\n0,0\n0.02,8\n" : "time_s,a_n,b_n\n0,0,4\n0.02,2,4\n"));
        ASSERT_TRUE(source.finish());
        while (source.next() && source.next()->time <= at(10ms)) ASSERT_TRUE(source.take(0));
        ControllerStep step{};
        step.time = at(12ms);
        step.true_force_n = source.true_force_n(step.time);
        step.parts.resize(2);
        source.tell_true_forces(step);
        EXPECT_DOUBLE_EQ(step.parts[0].true_force_n.value(), by_grip ? 0.5 * 4.8 : 1.2);
        EXPECT_DOUBLE_EQ(step.parts[1].true_force_n.value(), by_grip ? 0.25 * 4.8 : 4);
    }
}

// A single column in newtons would be the grip's, of which this element feels a half.
TEST_F(TableSources, TakeASingleColumnOfCountsForThoseOfTheElement) {
    const std::string one = "patch { name: 'a' elements: 1 share: 0.5 sensor { rate_hz: 200 adc_bits: 12 } }";
    const auto by_grip = samples(one, "time_s,force_n\n0,4\n");
    const auto by_counts = samples(one, "time_s,a_counts\n0,2048\n");
    ASSERT_EQ(by_grip.size(), 1U);
    ASSERT_EQ(by_counts.size(), 1U);
    const double newtons_a_count = 10.0 / 4095;  // of 10 N at full scale
    EXPECT_NEAR(by_grip[0].forces_n[0], 2, newtons_a_count);
    EXPECT_NEAR(by_counts[0].forces_n[0], 2048 * newtons_a_count, 1e-9);
    const auto held = samples(one, "time_s,a_counts\n0,2048\n0.01,1024\n", scene::Between::hold);
    ASSERT_FALSE(held.empty());
    EXPECT_NEAR(held.back().true_n.value(), 2048 * newtons_a_count, 1e-9) << "until the last row is taken";
}

TEST_F(TableSources, RefuseARowOutOfRangeBeforeTheWayToIt) {
    const auto all = samples(two_elements, "time_s,a_n,b_n\n0,0,8\n0.02,7,11\n", scene::Between::linear,
                             scene::OutOfRange::refuse);
    EXPECT_EQ(times(all), (std::vector<Duration>{0ms}));
    EXPECT_TRUE(refusal_.starts_with("x:3: beyond the full scale of patch \"a\"")) << refusal_;
    const auto none = samples(two_elements, "time_s,a_n,b_n\n0,0,-1\n0.02,7,1\n", scene::Between::linear,
                              scene::OutOfRange::refuse);
    EXPECT_TRUE(none.empty());
    EXPECT_TRUE(refusal_.starts_with("x:2: negative")) << refusal_;
}

TEST_F(TableSources, SayWhichLineTheyLeaveOut) {
    plan_ = make_plan(Scene::from_text("duration_s: 0.02 " + std::string(two_elements) +
                                       " source { table { path: 'x' } }"));
    const auto said = [&](const std::string& rows) {
        TableSource source(plan_, {.path = "x"});
        EXPECT_TRUE(source.feed("time_s,force_n\n" + rows));
        EXPECT_TRUE(source.finish());
        return source.said();
    };
    EXPECT_EQ(said("0,1\n0.02,1\n"), std::vector<std::string>{});
    EXPECT_EQ(said("0,1\n0.02,1\n0.025,1"),
              std::vector<std::string>{
                  "Forces: The last line, 4, has no newline and may be cut off: it is left out"});
}

TEST_F(TableSources, WaitForTheNextRowOfALiveTable) {
    plan_ = make_plan(Scene::from_text(std::string(two_elements) + " source { standard_input {} }"));
    TableSource source(plan_, {.path = "standard input", .between = scene::Between::hold});
    ASSERT_TRUE(source.feed("time_s,force_n\n0,1\n"));
    ASSERT_TRUE(source.next());
    ASSERT_TRUE(source.take(0));
    EXPECT_FALSE(source.next());
    EXPECT_TRUE(source.starving());
    ASSERT_TRUE(source.feed("0.02,5\n"));
    ASSERT_TRUE(source.next());
    EXPECT_EQ(source.next()->time, at(20ms));
}

TEST_F(TableSources, EndWithTheFirstRowThatIsNone) {
    plan_ = make_plan(Scene::from_text(std::string(two_elements) + " source { standard_input {} }"));
    int reads = 0;
    TableSource source(plan_, {.path = "x"}, [&](std::span<char> buffer) {
        ++reads;
        const std::string_view text = reads < 9 ? "time_s,force_n\n0,1,2\n" : "";
        std::ranges::copy(text, buffer.begin());
        return text.size();
    });
    EXPECT_FALSE(source.read_all());
    EXPECT_EQ(reads, 1);
    EXPECT_FALSE(source.next());
    EXPECT_EQ(reads, 1);
}

std::vector<double> emg_samples(scene::Between between, double rate_hz) {
    Scene scene;
    scene.hand.emg_rate_hz = rate_hz;
    scene.hand.emg_table = scene::EmgTable{.path = "x", .rest_counts = 2000.0, .between = between};
    EmgSource source = EmgSource::of(scene, {{at(2ms), at(6ms), at(7ms)}, {2100, 2500, 2400}});
    std::vector<double> counts;
    for (std::uint64_t k = 0; k < 10; ++k) counts.push_back(source.sample(k).closing_counts);
    return counts;
}

TEST(EmgSource, SamplesTheLineBetweenRowsThatAreFartherApartThanSamples) {
    EXPECT_EQ(emg_samples(scene::Between::linear, 1000),
              (std::vector<double>{2000, 2000, 2100, 2200, 2300, 2400, 2500, 2400, 2000, 2000}));
    EXPECT_EQ(emg_samples(scene::Between::hold, 1000),
              (std::vector<double>{2000, 2000, 2100, 2100, 2100, 2100, 2500, 2400, 2000, 2000}));
    // At 0, 4 and 8 ms and so on.
    const std::vector<double> held{2000, 2100, 2000, 2000, 2000, 2000, 2000, 2000, 2000, 2000};
    EXPECT_EQ(emg_samples(scene::Between::hold, 250), held);
    EXPECT_EQ(emg_samples(scene::Between::linear, 250), held) << "rows at 250 Hz or faster are held";
}

TEST(EmgSource, BeginsAgainBeforeItsFirstRow) {
    Scene scene;
    scene.hand.emg_table = scene::EmgTable{.path = "x", .rest_counts = 2000.0};
    EmgSource source = EmgSource::of(scene, {{at(2ms), at(500ms), at(1s)}, {2100, 2500, 2400}});
    EXPECT_EQ(source.sample(0).closing_counts, 2000);
    EXPECT_EQ(source.sample(static_cast<std::uint64_t>(scene.hand.emg_rate_hz)).closing_counts, 2400);
    source.restart();
    EXPECT_EQ(source.sample(0).closing_counts, 2000);
}

}  // namespace
}  // namespace afferent
