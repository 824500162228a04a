// Forces and EMG that a program holds in memory, and results that it is given there.
#include "afferent/nodes/given_tables.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "afferent/nodes/run.hpp"
#include "afferent/studies/kept_results.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

constexpr std::size_t given_scans = 200;

// Forces of three elements, every 5 ms.
std::vector<double> given_forces_n() {
    std::vector<double> forces_n;
    for (std::size_t i = 0; i < given_scans; ++i)
        for (const double factor : {0.5, 1.0, 1.5}) forces_n.push_back(factor * static_cast<double>(i) / 64);
    return forces_n;
}

std::vector<double> given_times_s() {
    std::vector<double> times_s;
    for (std::size_t i = 0; i < given_scans; ++i) times_s.push_back(static_cast<double>(i) / 200);
    return times_s;
}

Scene given_scene(const std::string& forces, const std::string& emg, const std::string& column) {
    Scene scene;
    scene.duration_s = 1;
    scene.patches = {{.name = "thumb"}};
    scene.source = scene::Table{.path = forces, .column = {column}};
    if (column.empty()) std::get<scene::Table>(scene.source).column.clear();
    scene.hand.emg_table.emplace().path = emg;
    scene.decoder.kind = scene::Filter();
    scene.decoder.parts = scene::Parts::elements;
    return scene;
}

KeptResults kept_results_of(const Scene& scene, GivenTables given) {
    const Plan plan = make_plan(scene);
    KeptResults kept;
    auto run = Run::open(plan,
                         {.events = [&](std::span<const Event> events) { kept.add(events); },
                          .step = [&](const ControllerStep& step) { kept.add(step); }},
                         {}, nullptr, std::move(given));
    EXPECT_TRUE(run) << (run ? "" : run.error().text);
    if (!run) return kept;
    while (!run.value()->done()) EXPECT_TRUE(run.value()->do_next());
    run.value()->finish(plan.end());
    return kept;
}

TEST(GivenTables, AreReadAsTheirFilesWouldBe) {
    const std::filesystem::path folder = std::filesystem::temp_directory_path() / "afferent_given_tables";
    std::filesystem::create_directories(folder);
    const std::vector<double> forces_n = given_forces_n();
    const std::vector<double> times_s = given_times_s();
    std::ofstream forces(folder / "forces.csv");
    std::ofstream emg(folder / "emg.csv");
    forces << "time_s,a_n,b_n,c_n\n";
    emg << "time_s,emg\n";
    forces.precision(17);
    emg.precision(17);
    EmgTable emg_table;
    for (std::size_t i = 0; i < given_scans; ++i) {
        forces << times_s[i] << ',' << forces_n[3 * i] << ',' << forces_n[3 * i + 1] << ','
               << forces_n[3 * i + 2] << '\n';
        const double counts = 2048 + 10.0 * static_cast<double>(i % 7);
        emg << times_s[i] << ',' << counts << '\n';
        emg_table.times.push_back(scene_start + from_seconds(times_s[i]));
        emg_table.counts.push_back(counts);
    }
    forces.close();
    emg.close();
    const KeptResults of_files =
        kept_results_of(given_scene(folder / "forces.csv", folder / "emg.csv", ""), {});
    const KeptResults of_memory =
        kept_results_of(given_scene("forces", "emg", "forces_n"),
                        {value_or_throw(ScanSet::of(times_s, 1, 3, false, forces_n)), std::move(emg_table)});
    std::filesystem::remove_all(folder);

    ASSERT_FALSE(of_files.events.empty());
    EXPECT_EQ(of_files.events, of_memory.events);
    ASSERT_EQ(of_files.steps.size(), 1000U);
    ASSERT_EQ(of_memory.steps.size(), 1000U);
    ASSERT_EQ(of_memory.parts.size(), 3000U);
    for (std::size_t i = 0; i < 1000; ++i) {
        EXPECT_EQ(of_files.steps[i].estimate_n, of_memory.steps[i].estimate_n);
        EXPECT_EQ(of_files.steps[i].closing_effort, of_memory.steps[i].closing_effort);
    }
    EXPECT_NEAR(of_memory.steps.back().true_force_n, 3.0 * 199 / 64, 1e-12);
    EXPECT_EQ(of_memory.parts.back().true_force_n, 1.5 * 199 / 64);
}

TEST(GivenTables, OfOneColumnAreTheGripForce) {
    const std::vector<double> grip_n(given_scans, 6.0);
    const std::vector<double> times_s = given_times_s();
    const KeptResults kept = kept_results_of(given_scene("forces", "emg", "forces_n"),
                                             {value_or_throw(ScanSet::of(times_s, 1, 1, false, grip_n)),
                                              EmgTable{.times = {scene_start}, .counts = {2048}}});
    ASSERT_FALSE(kept.steps.empty());
    ASSERT_FALSE(kept.parts.empty());
    EXPECT_EQ(kept.steps.back().true_force_n, 6);
    EXPECT_EQ(kept.parts.back().true_force_n, 2);  // of three elements that share it
}

TEST(GivenTables, ThatDoNotFitAreRefused) {
    const std::vector<double> values(4 * given_scans, 1.0);
    const std::vector<double> times_s = given_times_s();
    const Plan plan = make_plan(given_scene("forces", "emg", "forces_n"));
    const auto run = Run::open(plan, {}, {}, nullptr,
                               {value_or_throw(ScanSet::of(times_s, 1, 4, false, values)), EmgTable{}});
    ASSERT_FALSE(run);
    EXPECT_NE(run.error().text.find("4 values in a scan, and the scene has 3 elements"), std::string::npos);
    EXPECT_FALSE(ScanSet::of(times_s, 1, 3, false, values));
    EXPECT_FALSE(ScanSet::of({}, 1, 3, false, {}));
    const std::vector<double> falling{1, 0};
    EXPECT_FALSE(ScanSet::of(falling, 1, 1, false, falling));
}

TEST(KeptResults, HaveNaNForWhatIsNotKnown) {
    KeptResults kept;
    ControllerStep step{};
    step.time = scene_start + 3ms;
    step.estimate.force_n = 2;
    EdgeTouch touch;
    touch.edge.orientation_deg = 30;
    step.readouts = {touch};
    kept.add(step);
    ASSERT_EQ(kept.steps.size(), 1U);
    EXPECT_EQ(kept.steps[0].time_ns, 3'000'000);
    EXPECT_EQ(kept.steps[0].estimate_n, 2);
    EXPECT_TRUE(std::isnan(kept.steps[0].true_force_n));
    const std::vector<std::byte>& row = kept.readouts[1];
    ASSERT_EQ(row.size(), kept_row_bytes(EdgeTouch()));
    int known = 0;
    int unknown = 0;
    for (const KeptColumn& column : kept_columns(EdgeTouch())) {
        ASSERT_LT(column.offset, row.size());
        double value = 0;
        std::memcpy(&value, row.data() + column.offset, std::min(sizeof value, row.size() - column.offset));
        if (column.name == std::string("orientation_deg")) {
            EXPECT_EQ(value, 30);
            ++known;
        }
        if (column.name == std::string("speed_mm_per_s")) {
            EXPECT_TRUE(std::isnan(value));
            ++unknown;
        }
    }
    EXPECT_EQ(known, 1);
    EXPECT_EQ(unknown, 1);
}

}  // namespace
}  // namespace afferent
