// Recorded EMG in volts and counts, raw and as an envelope.
#include "afferent/nodes/emg_signal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <numeric>
#include <random>

#include "afferent/hand/emg_envelope.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

// Samples of `volts(t)` at a rate, for ten seconds.
template <class Volts>
Table emg_in(const std::string& column, double rate_hz, const Volts& volts) {
    Table table{.file = "emg.csv", .columns = {column}, .times = {}, .values = {}};
    for (std::uint64_t k = 0; k < static_cast<std::uint64_t>(10 * rate_hz); ++k) {
        table.times.push_back(sample_time(k, rate_hz));
        table.values.push_back(volts(seconds(table.times.back())));
    }
    return table;
}

// The amplitude of a sine in the middle third, in counts.
double amplitude_counts(const EmgTable& emg, double rest_counts) {
    double squares = 0;
    const std::size_t third = emg.counts.size() / 3;
    for (std::size_t i = third; i < 2 * third; ++i) squares += std::pow(emg.counts[i] - rest_counts, 2);
    return std::sqrt(2 * squares / static_cast<double>(third));
}

double sine_passes(double hz, double rate_hz) {
    const auto sine = [hz](double t) { return 1e-3 * std::sin(2 * std::numbers::pi * hz * t); };
    // One millivolt of the envelope is 1,000 counts.
    const scene::EmgTable asked{
        .full_scale_counts = 1000, .signal = scene::EmgSignal::raw, .full_scale_v = 1e-3};
    return amplitude_counts(read_emg(emg_in("emg_v", rate_hz, sine), asked, 40).table, User::rest_counts) /
           1000;
}

// A Butterworth filter of second order passes 1/√(1 + (f/corner)^±4), on the warped frequency axis.
TEST(EmgSignal, PassesTheBandOfMuscles) {
    const auto warped = [](double hz) { return std::tan(std::numbers::pi * hz / 2000); };
    const auto expected = [&](double hz) {
        return 1 / std::sqrt(1 + std::pow(warped(20) / warped(hz), 4)) /
               std::sqrt(1 + std::pow(warped(hz) / warped(450), 4));
    };
    for (const double hz : {2.0, 5.0, 20.0, 80.0, 200.0, 450.0, 800.0})
        EXPECT_NEAR(sine_passes(hz, 2000), expected(hz), 0.005) << hz;  // not a whole number of periods
    EXPECT_NEAR(sine_passes(90, 200), std::sqrt(0.5), 0.01) << "0.45 of the rate is the upper corner then";
}

TEST(EmgSignal, ScalesTheStrongestContractionOfRawVoltsToFullScale) {
    std::mt19937_64 random(1);
    std::normal_distribution<double> gauss;
    const auto raw = [&](double t) { return 1.65 + (t > 4 && t < 8 ? 2e-4 : 4e-6) * gauss(random); };
    const EmgReading reading = read_emg(emg_in("emg", 1000, raw), {}, 40);
    EXPECT_EQ(reading.said.rfind(
                  "EMG: column \"emg\" is in volts, raw, band-passed from 20 to 450 Hz, scaled so that ", 0),
              0U)
        << reading.said;
    ASSERT_EQ(reading.table.rest_counts, User::rest_counts);
    EmgEnvelope envelope({.time_constant_ms = 40, .rest_counts = 2048, .full_scale_counts = 500}, 1ms);
    std::vector<double> efforts;
    for (const double counts : reading.table.counts) efforts.push_back(envelope(counts));
    ASSERT_EQ(efforts.size(), 10'000U);
    EXPECT_LT(efforts[3900], 0.05) << "at rest";
    // The mean of the contraction is less than what its envelope exceeds 1 % of the time.
    const double mean = std::accumulate(efforts.begin() + 4500, efforts.begin() + 7900, 0.0) / 3400;
    EXPECT_GT(mean, 0.6);
    EXPECT_LT(mean, 1);
}

TEST(EmgSignal, TakesASmoothSignalForAnEnvelope) {
    const auto smooth = [](double t) {
        return 0.1 + (t > 4 && t < 8 ? 0.5 * std::sin((t - 4) * std::numbers::pi / 4) : 0);
    };
    const EmgReading reading = read_emg(emg_in("EMG [mV]", 1000, smooth), {}, 40);
    EXPECT_NE(
        reading.said.find("in volts, an envelope without its level at rest of 0.1 mV, scaled so that 0.4"),
        std::string::npos)
        << reading.said;
    ASSERT_FALSE(reading.table.counts.empty());
    EXPECT_EQ(reading.table.counts.front(), 2048);
    EXPECT_NEAR(*std::ranges::max_element(reading.table.counts), 2548, 5);
}

// One twentieth of a ramp of 10 mV/s over ten seconds is below 5 mV.
TEST(EmgSignal, TakesWhatATwentiethOfAnEnvelopeIsBelowForItsRest) {
    const EmgReading reading = read_emg(emg_in("emg_v", 1000, [](double t) { return 0.01 * t; }), {}, 40);
    EXPECT_NE(reading.said.find("without its level at rest of 4.99 mV, scaled so that 94 mV"),
              std::string::npos)
        << reading.said;
}

TEST(EmgSignal, LeavesCountsAsTheyAre) {
    const auto counts = [](double t) { return std::floor(2000 + 100 * std::sin(400 * t)); };
    const Table table = emg_in("emg", 1000, counts);
    const EmgReading reading = read_emg(table, {}, 40);
    EXPECT_EQ(reading.table.counts, table.values);
    EXPECT_EQ(reading.said, "");
    EXPECT_FALSE(reading.table.rest_counts);
    EXPECT_NE(read_emg(table, {.signal = scene::EmgSignal::raw}, 40).said.find("in counts, raw, band-passed"),
              std::string::npos);
}

TEST(EmgSignal, TakesFractionsForVoltsOnlyWhereTheyMayBe) {
    const auto scaled = [](double rest, double size, const scene::EmgTable& asked) {
        return !read_emg(emg_in("emg", 1000, [=](double t) { return rest + size * std::sin(700 * t); }),
                         asked, 40)
                    .said.empty();
    };
    EXPECT_FALSE(scaled(2048, 100.5, {})) << "no electrode gives 2 kV";
    EXPECT_FALSE(scaled(0, 250.5, {})) << "microvolts without a unit go around 0 as counts do";
    EXPECT_FALSE(scaled(0.5, 0.25, {.rest_counts = 0.5, .full_scale_counts = 1})) << "the scene says counts";
    EXPECT_TRUE(scaled(1.65, 0.001, {}));
    EXPECT_TRUE(scaled(2048, 100.5, {.unit = scene::EmgUnit::volts}));
}

TEST(EmgSignal, WithoutAnyContractionStaysAtRest) {
    const EmgReading reading = read_emg(emg_in("emg_v", 1000, [](double) { return 0.5; }), {}, 40);
    ASSERT_EQ(reading.table.counts.size(), 10'000U);
    for (const double counts : reading.table.counts) ASSERT_EQ(counts, User::rest_counts);
}

class EmgBesideForces : public testing::Test {
  protected:
    EmgBesideForces() { std::filesystem::create_directories(folder_); }
    ~EmgBesideForces() override { std::filesystem::remove_all(folder_); }
    void write(const char* name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
    EmgSource open(const std::string& scene) const {
        Scene read = Scene::from_text(scene, "scene", folder_);
        read.duration_s = 5;
        return value_or_throw(EmgSource::open(read));
    }
    std::filesystem::path folder_ = std::filesystem::path(testing::TempDir()) /
                                    ("afferent-emg-" + std::to_string(std::random_device()()));
};

TEST_F(EmgBesideForces, IsNotMadeUp) {
    EmgSource rests = open("source { table { path: 'f.csv' } }");
    for (std::uint64_t k = 0; k < 5000; ++k) {
        ASSERT_EQ(rests.sample(k).closing_counts, User::rest_counts);
        ASSERT_EQ(rests.sample(k).opening_counts, User::rest_counts);
    }
    EXPECT_EQ(rests.said(),
              std::vector<std::string>{
                  "EMG: none beside the recorded force, so both muscles rest (--emg names a table)"});
    EmgSource asked = open("source { table { path: 'f.csv' } } hand { user { effort: 0.6 } }");
    EXPECT_EQ(asked.said(),
              std::vector<std::string>{"EMG: that of the scene's simulated user, beside a recorded force"});
    EXPECT_NE(asked.sample(2000).closing_counts, User::rest_counts);
    EXPECT_TRUE(open("").said().empty()) << "a simulated hand has its user";
}

TEST_F(EmgBesideForces, BeginsWithThemByTheClockOfBoth) {
    write("f.csv", "time_s,f_n\n1000,1\n1001,1\n1002,2\n");
    write("e.csv", "time_s,emg\n999.5,2000\n1000.5,2100\n1001,2200\n");
    EmgSource source =
        open("source { table { path: 'f.csv' } } hand { emg_table { path: 'e.csv' between: HOLD } }");
    EXPECT_EQ(source.table().times, (std::vector<TimePoint>{scene_start + 500ms, scene_start + 1s}));
    EXPECT_EQ(source.said(),
              (std::vector<std::string>{"EMG: by its clock it begins 0.5 s before the forces",
                                        "EMG: the table ends at 1 s, and the muscle rests from then on"}));
    // A scene that says where one of them begins has it begin there.
    EXPECT_EQ(
        open("source { table { path: 'f.csv' begin_s: 1000 } } hand { emg_table { path: 'e.csv' } }").said(),
        (std::vector<std::string>{"EMG: the table's time 999.5 s is the scene's 0",
                                  "EMG: the table ends at 1.5 s, and the muscle rests from then on"}));
    write("e.csv", "time_s,emg\n5000,2000\n5000.5,2100\n5006,2200\n");
    EXPECT_EQ(
        open("source { table { path: 'f.csv' } } hand { emg_table { path: 'e.csv' } }").said(),
        std::vector<std::string>{"EMG: its times are none of the table of forces, and it begins with it"});
}

}  // namespace
}  // namespace afferent
