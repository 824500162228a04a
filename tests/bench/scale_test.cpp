// What the scale benchmark measures is a population, and what it says of it follows from what was measured.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "afferent/scene/plan.hpp"
#include "bench/energy_meter.hpp"
#include "bench/machine_memory.hpp"
#include "bench/scale_bench.hpp"
#include "bench/scale_export.hpp"
#include "bench/scale_population.hpp"
#include "bench/scale_ranks.hpp"
#include "bench/scale_tables.hpp"

namespace afferent::bench {
namespace {

std::filesystem::path fresh_scale_folder(const std::string& name) {
    const auto folder = std::filesystem::path(testing::TempDir()) / ("afferent_scale_" + name);
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    return folder;
}

std::string text_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST(ScalePopulation, FiresWhereItIsTouchedAndNotAsOne) {
    for (const Contact contact : {Contact::block, Contact::scattered}) {
        const ScalePopulation population{.elements = 1000, .active_fraction = 0.1, .contact = contact};
        const ScaleTouch touch(population);
        RunningScale running({population, scene::Form::sparse}, touch);
        for (int frame = 0; frame < 100; ++frame) (void)running.frame();
        std::set<Address> fired;
        std::set<TimePoint> times;
        std::size_t events = 0;
        constexpr int frames = 200;
        for (int frame = 0; frame < frames; ++frame)
            for (const Event& event : running.frame()) {
                fired.insert(event.address);
                times.insert(event.time);
                ++events;
            }
        std::set<Address> touched;
        for (std::uint32_t i = 0; i < population.active(); ++i) touched.insert(touch.element(i));
        EXPECT_EQ(fired, touched);
        ASSERT_EQ(touched.size(), 100U);
        EXPECT_EQ(*touched.rbegin(), contact == Contact::block ? 99U : 990U);
        // Tuned to 30 Hz at the mean force. The rate is nearly linear in it, and a neuron whose threshold is
        // 2 % off fires at a rate that is off by less than a tenth; they average out.
        EXPECT_NEAR(static_cast<double>(events) / 100 / (frames * seconds(scale_frame)), 30, 1.5);
        // No two spikes of 3,000 at the same nanosecond of a second, but for chance: 3,000²/2/1e9 = 0.0045.
        EXPECT_GE(times.size() + 1, events);
    }
}

TEST(ScalePopulation, IsSilentWhereNothingTouchesIt) {
    const ScalePopulation population{.elements = 2000, .active_fraction = 0};
    const ScaleTouch touch(population);
    RunningScale running({population, scene::Form::sparse}, touch);
    for (int frame = 0; frame < 200; ++frame) EXPECT_TRUE(running.frame().empty());
}

TEST(ScalePopulation, LeavesOutWhatItIsToldTo) {
    EXPECT_FALSE(make_plan(scale_scene({{.elements = 9}})).patches.front().variations.empty());
    const Plan plain = make_plan(scale_scene({{.elements = 9, .adapts = false, .differs = false}}));
    EXPECT_TRUE(plain.patches.front().variations.empty());
    EXPECT_EQ(std::get<LifParameters>(plain.patches.front().neuron).delta_g, 0);
    EXPECT_FALSE(plain.controller);
    EXPECT_FALSE(plain.packets);
}

TEST(ScaleBench, TellsEventsThatDifferFromThoseThatAreRoundedOtherwise) {
    const auto at = [](std::int64_t ns) { return scene_start + Duration(ns); };
    const TimePoint end = at(1000);
    const auto same = [&](std::vector<Event> these, std::vector<Event> those) {
        try {
            require_same_events(these, those, end, "these and those");
            return true;
        } catch (const std::runtime_error& error) {
            EXPECT_NE(std::string(error.what()).find("these and those differ"), std::string::npos);
            return false;
        }
    };
    EXPECT_TRUE(same({{at(10), 1}, {at(11), 0}}, {{at(11), 1}, {at(11), 0}}));
    EXPECT_FALSE(same({{at(10), 1}}, {{at(12), 1}}));
    EXPECT_FALSE(same({{at(10), 1}}, {{at(10), 2}}));
    EXPECT_FALSE(same({{at(10), 1}, {at(20), 1}}, {{at(10), 1}}));
    EXPECT_FALSE(same({}, {{at(10), 1}}));
    // Either side of the end.
    EXPECT_TRUE(same({{at(999), 1}, {at(5), 2}}, {{at(5), 2}}));
    EXPECT_FALSE(same({{at(997), 1}, {at(5), 2}}, {{at(5), 2}}));
}

TEST(ScaleBench, FindsWhereTheSweepTakesOver) {
    // Prediction 200 ns for each that is touched, the sweep 5 ns for each and 15 more for each that is: at
    // f = 5/185.
    std::vector<ScaleRow> rows;
    for (const double fraction : {0.0, 0.01, 0.1, 1.0})
        for (const scene::Form form : {scene::Form::sparse, scene::Form::dense}) {
            const double ns = form == scene::Form::sparse ? 200 * fraction : 5 + 15 * fraction;
            ScaleRow row{.run = {{.elements = 1000, .active_fraction = fraction}, form}, .cost = {}};
            row.cost.frame_s = 1e-9 * 1000 * ns;
            rows.push_back(row);
            // Neither threads nor scattered contacts count.
            row.run.threads = 2;
            row.cost.frame_s = 1;
            rows.push_back(row);
        }
    const std::vector<ScaleCrossing> found = crossings(rows);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found.front().elements, 1000U);
    ASSERT_TRUE(found.front().fraction);
    EXPECT_NEAR(*found.front().fraction, 5.0 / 185, 1e-12);
    EXPECT_TRUE(found.front().sparse_when_idle);

    std::erase_if(rows, [](const ScaleRow& row) { return row.run.population.active_fraction > 0.01; });
    EXPECT_FALSE(crossings(rows).at(0).fraction);
}

TEST(ScaleBench, WritesATableOfConsistentFigures) {
    ScaleReport report;
    report.rows = measure_scale({.elements = {9, 40}, .quick = true}, [](double) {});
    const auto folder = fresh_scale_folder("table");
    write_scale(report, folder);
    EXPECT_TRUE(text_of(folder / "scale.csv")
                    .starts_with("elements,active_fraction,schedule,threads,ranks,realtime_factor,"
                                 "ns_per_element_frame,events_per_s,bytes_per_element"));
    std::set<std::pair<std::uint32_t, scene::Form>> seen;
    for (const ScaleRow& row : report.rows) {
        const ScalePopulation& population = row.run.population;
        seen.insert({population.elements, row.run.form});
        EXPECT_NEAR(row.cost.realtime_factor() * row.ns() * population.elements, 5e6, 1e-3);
        EXPECT_LE(row.cost.least_s, row.cost.frame_s);
        EXPECT_LE(row.cost.frame_s, row.cost.most_s);
        EXPECT_GT(row.bytes_per_element(), sizeof(double));
        EXPECT_EQ(population.active_fraction > 0, row.cost.events_per_frame > 0);
        EXPECT_EQ(row.run.threads, 1U) << "too few elements for two";
    }
    EXPECT_EQ(seen.size(), 6U);
}

TEST(ScaleBench, ComparesRunsOfSeveralPopulations) {
    const ScaleRun all{{.elements = 300}, scene::Form::dense};
    ScaleRun part = all;
    part.population.active_fraction = 0.1;
    const auto costs = measure_together({all, part, {all.population, scene::Form::sparse, 2}},
                                        {.settling_frames = 40, .repeats = 3, .repeat_s = 0.001});
    ASSERT_EQ(costs.size(), 3U);
    EXPECT_GT(costs[0].events_per_frame, 5 * costs[1].events_per_frame);
    for (const ScaleCost& cost : costs) EXPECT_GT(cost.frame_s, 0);
}

TEST(ScaleRanks, SayWhyThereAreNone) {
    const auto folder = fresh_scale_folder("no_ranks");
    const ScaleRanks found = measure_scale_ranks(folder / "afferent", true, [](double) {});
    EXPECT_TRUE(found.rows.empty());
    EXPECT_NE(found.unavailable.find((folder / "afferent-ranks").string()), std::string::npos);
}

TEST(ScaleRanks, AreHeldAgainstProcessesThatExchangeNothing) {
    ScaleRanks ranks{.halves_s = 0.5};
    for (const double least_wall_s : {1.0, 0.625}) {
        ranks.rows.push_back({});
        ranks.rows.back().cost.least_wall_s = least_wall_s;
    }
    const auto targets = two_ranks_targets(ranks, false);
    ASSERT_EQ(targets.size(), 2U);
    EXPECT_DOUBLE_EQ(targets[0].value, 1.6);
    EXPECT_EQ(targets[0].asked, 1.8);
    EXPECT_DOUBLE_EQ(targets[1].value, 2);
    EXPECT_FALSE(targets[1].asked);
}

TEST(ScaleRanks, ReadTheNumbersOfARun) {
    const std::string json = "{\n  \"events\": 12,\n  \"run_time_s\": 0.25,\n  \"estimate_n\": null\n}";
    EXPECT_EQ(number_in_json(json, "events"), 12);
    EXPECT_EQ(number_in_json(json, "run_time_s"), 0.25);
    EXPECT_THROW((void)number_in_json(json, "estimate_n"), std::runtime_error);
    EXPECT_THROW((void)number_in_json(json, "time_s"), std::runtime_error);
}

TEST(ScaleExport, WritesWhatNumpyReads) {
    const auto folder = fresh_scale_folder("export");
    const ScaleExport exported = export_population(20, 100ms, folder);
    EXPECT_GT(exported.events, 20U);
    const std::string drives = text_of(folder / "drives_mv.npy");
    ASSERT_TRUE(drives.starts_with("\x93NUMPY\x01"));
    ASSERT_GT(drives.size(), 10U);
    const std::size_t header =
        static_cast<unsigned char>(drives[8]) + 256U * static_cast<unsigned char>(drives[9]);
    EXPECT_EQ((10 + header) % 64, 0U);
    EXPECT_NE(drives.find("'shape': (20, 20)"), std::string::npos);
    EXPECT_EQ(drives.size(), 10 + header + 20 * 20 * sizeof(double));
    const std::string addresses = text_of(folder / "spike_address.npy");
    EXPECT_NE(addresses.find("'shape': (" + std::to_string(exported.events) + ",)"), std::string::npos);
    EXPECT_TRUE(text_of(folder / "parameters.csv").starts_with("elements,frames,frame_ms,tau_m_ms"));
}

TEST(EnergyMeter, AddsPackagesAndCountersThatBeginAgain) {
    const auto folder = fresh_scale_folder("rapl");
    const auto write = [&](const std::string& package, const std::string& file, std::uint64_t value) {
        std::filesystem::create_directories(folder / package);
        std::ofstream(folder / package / file) << value << '\n';
    };
    for (const char* const package : {"intel-rapl:0", "intel-rapl:1", "intel-rapl:0:0"})
        write(package, "max_energy_range_uj", 1'000'000'000);
    write("intel-rapl:0", "energy_uj", 5'000'000);
    write("intel-rapl:1", "energy_uj", 999'000'000);
    write("intel-rapl:0:0", "energy_uj", 0);
    EnergyMeter meter(folder);
    EXPECT_TRUE(meter.unavailable().empty());
    write("intel-rapl:0", "energy_uj", 7'000'000);
    write("intel-rapl:1", "energy_uj", 3'000'000);
    write("intel-rapl:0:0", "energy_uj", 900'000'000);  // a part of package 0, not counted twice
    EXPECT_NEAR(meter.joules().value(), 2 + 4, 1e-9);
    EXPECT_NEAR(meter.joules().value(), 0, 1e-9);
}

TEST(EnergyMeter, SaysWhyThereIsNothingToRead) {
    const auto folder = fresh_scale_folder("no_rapl");
    EnergyMeter none(folder);
    EXPECT_NE(none.unavailable().find("no RAPL counters in " + folder.string()), std::string::npos);
    EXPECT_FALSE(none.joules());
    std::filesystem::create_directories(folder / "intel-rapl:0");
    EXPECT_NE(EnergyMeter(folder).unavailable().find("root only"), std::string::npos);
}

TEST(MachineMemory, CountsWhatIsInUse) {
    const std::size_t before = resident_bytes();
    constexpr std::size_t size = 64UL << 20;
    {
        const std::vector<double> used(size / sizeof(double), 1.0);
        EXPECT_GT(used.back(), 0);
        // The process may have given back a little of other things.
        EXPECT_GT(resident_bytes() + (size >> 4), before + size);
    }
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // which keep what is freed
    EXPECT_LT(resident_bytes(), before + (size >> 1));
#endif
    EXPECT_GT(memory_bytes_per_s(1, 1 << 20), 1e6);
}

}  // namespace
}  // namespace afferent::bench
