// What a table is found to be, and the scene for it.
#include "afferent/studies/inspect.hpp"

#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "afferent/nodes/run.hpp"
#include "afferent/nodes/table_columns.hpp"
#include "tests/shared_data.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

// Rows at a rate; value(column, t).
template <class Value>
Table table_with(std::vector<std::string> columns, double rate_hz, std::size_t rows, const Value& value) {
    Table table{.file = "t.csv", .columns = std::move(columns), .times = {}, .values = {}};
    for (std::size_t k = 0; k < rows; ++k) {
        table.times.push_back(sample_time(k, rate_hz));
        for (std::size_t i = 0; i < table.columns.size(); ++i)
            table.values.push_back(value(i, seconds(table.times.back())));
    }
    return table;
}

using ColumnUse = ColumnInspection::Use;

TEST(TableInspections, TellRateGapsAndRanges) {
    Table table = table_with({"force_n"}, 100, 300, [](std::size_t, double t) { return t; });
    for (std::size_t i = 150; i < 300; ++i) table.times[i] += 70ms;
    for (std::size_t i = 250; i < 300; ++i) table.times[i] += 20ms;
    const TableInspection found = inspect(table, "t.csv");
    EXPECT_DOUBLE_EQ(found.rate_hz, 100);
    EXPECT_EQ(found.gaps, 2U);
    ASSERT_EQ(found.longest_gaps.size(), 2U);
    EXPECT_EQ(found.longest_gaps[0].length, 80ms);
    EXPECT_EQ(found.longest_gaps[0].begin, scene_start + 1490ms);
    EXPECT_EQ(found.shortest_interval, 10ms);
    EXPECT_EQ(found.columns.at(0).lowest, 0);
    EXPECT_EQ(found.columns.at(0).highest, 2.99);
    EXPECT_EQ(found.columns.at(0).use, ColumnUse::grip_force);
    ASSERT_TRUE(found.scene);
    EXPECT_TRUE(found.assumptions.empty()) << "newtons need none";
    ASSERT_EQ(found.scene->patches.size(), 1U);
    EXPECT_EQ(found.scene->patches.at(0).elements, 1U) << "identical trains tell no more than one";
}

// Fitted to its range, the gain reaches 0 within the recording, and a hand that goes by it is accepted. It is
// never raised: newtons that are millinewtons would let a hand crush what it holds.
TEST(TableInspections, LowerTheGainForARecordingOfASmallRange) {
    for (const double highest_n : {0.4, 3.0, 20.0, 180.0, 5000.0}) {
        const auto table = table_with({"force_n"}, 100, 300, [&](std::size_t, double t) {
            return highest_n * std::max(0.0, std::sin(2 * t));
        });
        const TableInspection found = inspect(table, "t.csv");
        ASSERT_TRUE(found.scene) << found.why_no_scene;
        EXPECT_LT(found.scene->gain.limit_n, highest_n);
        EXPECT_GT(found.scene->gain.limit_n, std::min(20.0, highest_n) / 5);
        EXPECT_LE(found.scene->gain.limit_n, scene::Gain().limit_n);
        if (highest_n <= 20) {
            EXPECT_NO_THROW(make_plan(*found.scene, Commands::wanted)) << highest_n;
        }
    }
}

std::vector<double> three_forces(double t) {
    const double closing = std::max(0.0, std::sin(2 * t));
    return {3 * closing, 2 * closing * closing, t * closing};
}

// Whatever it is called and wherever it stands, written in full or to a millinewton.
TEST(TableInspections, TakeTheSumOfTheOtherForcesForACheck) {
    for (const auto& [at, is_rounded] : {std::pair(0U, true), {1U, true}, {3U, true}, {2U, false}}) {
        const auto table = table_with({"a_n", "b_n", "c_n", "d_n"}, 100, 300, [&](std::size_t i, double t) {
            const std::vector<double> forces = three_forces(t);
            const double sum = forces[0] + forces[1] + forces[2];
            if (i == at) return is_rounded ? 1e-3 * std::round(1e3 * sum) : sum;
            return forces[i < at ? i : i - 1];
        });
        const TableInspection found = inspect(table, "t.csv");
        ASSERT_TRUE(found.scene) << found.why_no_scene;
        ASSERT_EQ(found.columns.size(), 4U);
        for (std::size_t i = 0; i < 4; ++i)
            EXPECT_EQ(found.columns[i].use, i == at ? ColumnUse::not_used : ColumnUse::element_force);
        EXPECT_EQ(found.columns[at].reason, "it is the sum of the others: a check, and no sensor");
        EXPECT_EQ(found.scene->patches.at(0).elements, 3U);
        EXPECT_EQ(std::get<scene::Table>(found.scene->source).column.size(), 3U);
        EXPECT_TRUE(std::ranges::any_of(found.sentences, [&](const std::string& sentence) {
            return sentence.starts_with("Column \"" + table.columns[at] +
                                        "\" is the sum of the other forces" +
                                        (is_rounded ? ", within 0.000" : ":"));
        }));
    }
}

// A tenth off it is a sensor like the others; and of two columns that are alike neither is the other's sum.
TEST(TableInspections, TakeNoOtherColumnForASum) {
    const auto table = table_with({"a_n", "b_n", "c_n", "d_n"}, 100, 300, [](std::size_t i, double t) {
        const std::vector<double> forces = three_forces(t);
        return i < 3 ? forces[i] : 1.1 * (forces[0] + forces[1] + forces[2]);
    });
    const TableInspection found = inspect(table, "t.csv");
    EXPECT_EQ(found.scene.value().patches.at(0).elements, 4U);
    ASSERT_EQ(found.assumptions.size(), 1U);
    EXPECT_TRUE(found.assumptions[0].starts_with(
        "Column \"d_n\" is a sensor of its own, although it is nearly the sum of the other forces"));
    const auto twins =
        table_with({"a_n", "b_n"}, 100, 300, [](std::size_t, double t) { return three_forces(t)[0]; });
    EXPECT_EQ(inspect(twins, "t.csv").scene.value().patches.at(0).elements, 2U);
}

TEST(TableInspections, AskWhetherASignIsReversed) {
    const auto with_signs = [](double first, double second) {
        return inspect(table_with({"a_n", "b_n"}, 100, 300,
                                  [&](std::size_t i, double t) {
                                      return (i == 0 ? first : second) * three_forces(t)[i];
                                  }),
                       "t.csv");
    };
    EXPECT_TRUE(with_signs(1, 1).assumptions.empty());
    const TableInspection both = with_signs(-1, -1);
    EXPECT_FALSE(both.scene);
    EXPECT_TRUE(both.why_no_scene.starts_with("all forces are negative, or 0: is the sign reversed?"));
    const TableInspection one = with_signs(1, -1);
    EXPECT_TRUE(one.scene);
    ASSERT_EQ(one.assumptions.size(), 1U);
    EXPECT_TRUE(one.assumptions[0].starts_with("The forces of \"b_n\" are farther below 0 than above it"));
}

TEST(TableInspections, TakeWholeNumbersForCountsAndRefuseOthersWithoutAUnit) {
    const auto counts = table_with({"a", "b"}, 100, 100, [](std::size_t i, double t) {
        return std::floor(500 + 500 * std::sin(6 * t + static_cast<double>(i)));
    });
    const TableInspection found = inspect(counts, "t.csv");
    ASSERT_TRUE(found.scene) << found.why_no_scene;
    EXPECT_EQ(found.columns.at(0).unit, "counts");
    EXPECT_EQ(found.scene->patches.at(0).sensor.adc_bits, 10U);
    EXPECT_EQ(std::get<scene::Table>(found.scene->source).unit, scene::TableUnit::counts);
    EXPECT_EQ(found.assumptions.size(), 2U);

    const auto nameless = table_with({"a"}, 100, 100, [](std::size_t, double t) { return t; });
    EXPECT_FALSE(inspect(nameless, "t.csv").scene);
    EXPECT_NE(inspect(nameless, "t.csv").why_no_scene.find("--unit newtons"), std::string::npos);
    EXPECT_TRUE(inspect(nameless, "t.csv", {.unit = scene::TableUnit::newtons}).scene);
}

TEST(TableInspections, GiveVoltsTheCalibrationOfAnFsrOrOnesOwn) {
    const auto volts = table_with({"a_v", "b_v"}, 250, 500, [](std::size_t i, double t) {
        return std::max(0.0, std::sin(1.5 * t)) * (i == 0 ? 4 : 3);
    });
    const TableInspection assumed = inspect(volts, "t.csv");
    ASSERT_TRUE(assumed.scene) << assumed.why_no_scene;
    EXPECT_EQ(assumed.assumptions.size(), 1U);
    const scene::Sensor& sensor = assumed.scene->patches[0].sensor;
    EXPECT_EQ(sensor.rate_hz, 250);
    EXPECT_EQ(sensor.reference_v, 5);
    // Six kiloohms, at 1 N, and ten below them: 5 V · 10/16.
    const Calibration calibration(sensor.calibration);
    EXPECT_NEAR(calibration.force_n(4095 * 10.0 / 16), 1, 0.001);
    EXPECT_NEAR(calibration.force_n(4095 * 10.0 / 11), 10, 0.02);

    const TableInspection linear = inspect(volts, "t.csv", {.newtons_per_volt = 2});
    EXPECT_TRUE(linear.assumptions.empty());
    EXPECT_DOUBLE_EQ(
        Calibration(linear.scene.value().patches.at(0).sensor.calibration).force_n(4095 * 3.0 / 5), 6);
    const TableInspection points =
        inspect(volts, "t.csv", {.calibration = {{0, 0}, {2, 1}, {4, 9}}, .reference_v = 4});
    EXPECT_DOUBLE_EQ(
        Calibration(points.scene.value().patches.at(0).sensor.calibration).force_n(4095 * 3.0 / 4), 5);
    // The columns are 4 : 3 under a linear sensor.
    EXPECT_NEAR(linear.scene.value().patches.at(0).share[0], 4.0 / 7, 1e-6);
}

// Wherever it is stuck, it neither sets the scale nor shares in the grip.
TEST(TableInspections, LeaveOutAColumnThatNeverChanges) {
    const auto table = table_with({"a_n", "b_n", "c_n"}, 100, 300, [](std::size_t i, double t) {
        return i == 1 ? 900.0 : (i == 0 ? 3 : 1) * std::max(0.0, std::sin(2 * t));
    });
    const TableInspection found = inspect(table, "t.csv");
    ASSERT_TRUE(found.scene) << found.why_no_scene;
    const scene::Patch& patch = found.scene->patches[0];
    ASSERT_EQ(patch.share.size(), 3U);
    EXPECT_NEAR(patch.share[0], 0.75, 1e-5);
    EXPECT_EQ(patch.share[1], 0);
    EXPECT_NEAR(patch.share[2], 0.25, 1e-5);
    EXPECT_EQ(patch.sensor.dead_element, std::vector<std::uint32_t>{1});
    EXPECT_EQ(patch.sensor.full_scale_n, 5) << "3 N, rounded up";
    const std::string said =
        "Column \"b_n\" never changes: it is taken for a dead sensor, and left out (share 0).";
    EXPECT_NE(std::ranges::find(found.sentences, said), found.sentences.end());
    EXPECT_LE(make_plan(*found.scene, Commands::recorded).controller.value().afferents.largest_grip_n,
              5 / 0.249);
}

TEST(TableInspections, FindForcesAndEmgInOneTable) {
    const auto table =
        table_with({"F [mN]", "emg_mv", "temperature_c"}, 1000, 2000, [](std::size_t i, double t) {
            return i == 0 ? 3000 * t : i == 1 ? std::sin(700 * t) * t : 37.0;
        });
    const TableInspection found = inspect(table, "t.csv");
    ASSERT_TRUE(found.scene) << found.why_no_scene;
    EXPECT_EQ(found.columns.at(0).use, ColumnUse::grip_force);
    EXPECT_EQ(found.columns.at(1).use, ColumnUse::emg);
    EXPECT_EQ(found.columns.at(2).use, ColumnUse::not_used);
    EXPECT_EQ(std::get<scene::Table>(found.scene->source).column, std::vector<std::string>{"F [mN]"});
    EXPECT_EQ(found.scene->hand.emg_table.value().column, "emg_mv");
}

// From the first row to the last, and as long for the last as for the mean of the others.
double length_of_table_s(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::vector<double> times_s;
    for (std::string line; std::getline(in, line);)
        if (!line.empty() && std::isdigit(static_cast<unsigned char>(line[0])))
            times_s.push_back(std::stod(line));
    const auto rows = static_cast<double>(times_s.size());
    return (times_s.back() - times_s.front()) * rows / (rows - 1);
}

// Recorded by others: each scene runs at once, for the table's length, and estimates its force.
TEST(TableInspections, GiveScenesThatRunOnRecordedTables) {
    for (const char* name : {"fsr5_fingertip.csv", "fsr5_palm.csv", "grip_human_1.csv"}) {
        const std::filesystem::path file = shared_data() / name;
        if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is absent";
        Scene scene = scene_for(file);
        EXPECT_FALSE(scene.duration_s);
        const Plan plan = make_plan(scene);
        EXPECT_NEAR(plan.scene.duration_s.value(), length_of_table_s(file), 1e-9) << name;
        double squares = 0;
        double true_squares = 0;
        const auto run = Run::open(plan, {.step = [&](const ControllerStep& step) {
                                       if (!step.true_force_n) return;
                                       squares += std::pow(step.estimate.force_n - *step.true_force_n, 2);
                                       true_squares += std::pow(*step.true_force_n, 2);
                                   }});
        ASSERT_TRUE(run) << run.error().text;
        while (!run.value()->done()) ASSERT_TRUE(run.value()->do_next());
        EXPECT_GT(run.value()->coprocessor().events(), 200U) << name;
        EXPECT_LT(std::sqrt(squares / true_squares), 0.2) << name << ": a fifth of the force";
    }
}

TEST(TableColumns, AreOfOneQuantity) {
    const auto columns = table_columns({"a_n", "b [mN]"}, scene::TableUnit::by_name);
    ASSERT_TRUE(columns);
    EXPECT_EQ(columns.value().quantity, Quantity::force);
    EXPECT_EQ(columns.value().factors, (std::vector<double>{1, 1e-3}));
    EXPECT_FALSE(table_columns({"a_n", "b_v"}, scene::TableUnit::by_name));
    EXPECT_FALSE(table_columns({"a"}, scene::TableUnit::by_name));
    EXPECT_EQ(value_or_throw(table_columns({"a"}, scene::TableUnit::volts)).quantity, Quantity::volts);
}

// A "g" may be an acceleration as well.
TEST(TableInspections, SayWhatToDoAboutMasses) {
    const Table table{.file = "t.csv",
                      .columns = {"load [kg]"},
                      .times = {scene_start, scene_start + 10ms},
                      .values = {0, 0.5}};
    const TableInspection found = inspect(table, "t.csv");
    EXPECT_FALSE(found.scene);
    EXPECT_EQ(found.why_no_scene,
              "no column is a force: kg is a mass: multiply \"load [kg]\" by 9.80665 and call it \"load_n\", "
              "or, if "
              "it is weights, call it \"load [kgf]\"");
}

// What is not looked at may differ from what is.
TEST(TableInspections, SayThatTheyLookAtTheFirstRowsOfALongTable) {
    Table table{
        .file = "t.csv", .columns = {"f_n"}, .times = {scene_start, scene_start + 10ms}, .values = {0, 0.5}};
    EXPECT_TRUE(inspect(table, "t.csv").assumptions.empty());
    table.format.is_cut = true;
    ASSERT_EQ(inspect(table, "t.csv").assumptions.size(), 1U);
    EXPECT_NE(inspect(table, "t.csv").assumptions[0].find("only its first 2 rows, up to 0.01 s"),
              std::string::npos);
}

}  // namespace
}  // namespace afferent
