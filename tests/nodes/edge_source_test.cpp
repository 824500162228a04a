// An edge that slides over the skin.
#include "afferent/nodes/edge_source.hpp"

#include <gtest/gtest.h>

#include <map>
#include <numbers>
#include <set>

#include "afferent/nodes/run.hpp"

namespace afferent {
namespace {

constexpr const char* quiet = "record { force: false picture: false } ";

Plan skin_under_edge(const std::string& edge, const std::string& sensor = "", const std::string& patch = "") {
    return make_plan(
        Scene::from_text("duration_s: 0.5 patch { name: 'skin' outline { rectangle { width_mm: 10 height_mm: "
                         "4 } pitch_mm: 0.5 } " +
                         patch + " sensor { rate_hz: 1000 full_scale_n: 0.1 adc_bits: 24 " + sensor +
                         " } } source { edge { " + edge + " } } " + quiet));
}

struct Touched {
    TimePoint time;
    std::map<std::uint32_t, double> forces_n;
};

// What the elements are told up to a time, scan by scan.
std::vector<Touched> touched_until(EdgeSource& source, TimePoint until) {
    std::vector<Touched> all;
    while (source.next()->time <= until) {
        const auto scan = source.take(0);
        if (!scan) {
            ADD_FAILURE() << source.refusal().text;
            break;
        }
        if (all.empty() || all.back().time != scan->time) all.push_back({scan->time, {}});
        for (std::size_t i = 0; i < scan->forces_n.size(); ++i)
            all.back().forces_n[scan->first + static_cast<std::uint32_t>(i)] = scan->forces_n[i];
    }
    return all;
}

// Hertz: a line contact carries π/2 · a · peak for each millimetre of its length, here the patch's height.
TEST(EdgeSource, PressesWithTheForceOfALineContact) {
    for (const char* direction : {"", "direction_deg: 180 "}) {
        const Plan plan = skin_under_edge(std::string(direction) +
                                          "speed_mm_per_s: 20 begin_mm: -3 half_width_mm: 0.8 peak_kpa: 30");
        EdgeSource source(plan);
        for (const Touched& scan : touched_until(source, scene_start + 250ms)) {
            double sum_n = 0;
            for (const auto& [element, force_n] : scan.forces_n) sum_n += force_n;
            // 160 readings of 24 bits.
            EXPECT_NEAR(sum_n, std::numbers::pi / 2 * 0.8 * 0.03 * 4, 160 * 0.1 / (1 << 24));
        }
    }
}

TEST(EdgeSource, MovesAtItsSpeedAlongItsDirection) {
    const Plan plan = skin_under_edge("direction_deg: 90 speed_mm_per_s: 10 begin_mm: -2 half_width_mm: 0.6");
    EdgeSource source(plan);
    const ElementGrid& grid = *plan.patches[0].grid;
    for (const Touched& scan : touched_until(source, scene_start + 350ms)) {
        double sum_n = 0;
        double moment = 0;
        for (const auto& [element, force_n] : scan.forces_n) {
            sum_n += force_n;
            moment += force_n * grid.place(element).y_mm;
        }
        const double middle_mm = -2 + 10 * seconds(scan.time);
        if (std::abs(middle_mm) > 1.4) continue;  // a part of it is beyond the skin
        EXPECT_NEAR(moment / sum_n, middle_mm, 0.05) << "cells of 0.5 mm do not tell more";
    }
}

// After the first scan, only cells that the edge touches or has just left are sampled.
TEST(EdgeSource, LeavesUntouchedSkinAlone) {
    const Plan plan = skin_under_edge("speed_mm_per_s: 20 begin_mm: -8 half_width_mm: 0.5");
    EdgeSource source(plan);
    const auto scans = touched_until(source, plan.end());
    ASSERT_GT(scans.size(), 100U);
    EXPECT_EQ(scans.front().forces_n.size(), plan.elements);
    EXPECT_EQ(scans[1].time, scene_start + 1ms) << "a slope ends one sample after its force";
    // 2.5 mm from the border to the reach of the edge take 125 ms.
    const auto later = std::find_if(scans.begin(), scans.end(),
                                    [](const Touched& scan) { return scan.time > scene_start + 10ms; });
    EXPECT_NEAR(seconds(later->time), 0.125, 0.0011) << "a sample at most later";
    std::size_t samples = 0;
    for (auto scan = later; scan != scans.end(); ++scan) {
        EXPECT_LE(scan->forces_n.size(), 8U * 4U) << "8 rows of 3 cells, and one that has been left";
        samples += scan->forces_n.size();
    }
    EXPECT_EQ(source.samples(), samples + static_cast<std::size_t>(later - scans.begin()) * plan.elements);
}

// An encoder with lags goes on being told until it has settled: the drive ends where it began.
TEST(EdgeSource, SamplesUntilTheEncodersHaveSettled) {
    const Plan plan = skin_under_edge("speed_mm_per_s: 100 begin_mm: -6 half_width_mm: 0.5", "",
                                      "encoder { vibration { gain_mv_s2_per_n: 1 corner_hz: 100 } }");
    EdgeSource source(plan);
    Vibration encoder({.gain = 1, .bias_mv = 0, .corner_hz = 100});
    std::map<std::uint32_t, Vibration::State> states;
    std::map<std::uint32_t, double> largest;
    std::map<std::uint32_t, double> last;
    for (const Touched& scan : touched_until(source, plan.end()))
        for (const auto& [element, force_n] : scan.forces_n) {
            last[element] = encoder.drive_mv(states[element], scan.time, force_n);
            largest[element] = std::max(largest[element], last[element]);
        }
    ASSERT_EQ(last.size(), plan.elements);
    for (const auto& [element, drive_mv] : last) EXPECT_LE(drive_mv, 1e-8 * largest[element]) << element;
}

TEST(EdgeSource, SamplesAllElementsOfNoisySensors) {
    const Plan plan = skin_under_edge("begin_mm: -100", "noise_counts: 3");
    EdgeSource source(plan);
    for (const Touched& scan : touched_until(source, scene_start + 20ms))
        EXPECT_EQ(scan.forces_n.size(), plan.elements);
    EXPECT_EQ(source.samples(), 21U * plan.elements);
}

TEST(EdgeSource, RefusesWhatIsBeyondFullScaleWhereTheSceneSaysSo) {
    const Plan plan = skin_under_edge("peak_kpa: 1e4 begin_mm: 0", "out_of_range: REFUSE");
    EdgeSource source(plan);
    while (source.take(0)) ASSERT_LE(source.next()->time, plan.end());
    EXPECT_NE(source.refusal().text.find("patch \"skin\": source.edge presses an element beyond full scale"),
              std::string::npos);
}

// SA1 fire under the edge, RA and PC at its borders; the edge has come and gone.
TEST(EdgeSource, DrivesTheFingertip) {
    const Plan plan = make_plan(Scene::from_file(AFFERENT_SOURCE_DIR "/examples/fingertip.txtpb"));
    EXPECT_NEAR(plan.addresses, 250, 15);
    std::vector<Event> events;
    Run::Output output;
    output.events = [&](std::span<const Event> more) {
        events.insert(events.end(), more.begin(), more.end());
    };
    const auto run = Run::open(plan, std::move(output));
    ASSERT_TRUE(run);
    while (!run.value()->done()) ASSERT_TRUE(run.value()->do_next());
    run.value()->finish(plan.end());
    for (const PatchPlan& patch : plan.patches) {
        std::set<Address> fired;
        for (const Event& event : events)
            if (event.address >= patch.first && event.address < patch.first + patch.afferents())
                fired.insert(event.address);
        EXPECT_GT(static_cast<double>(fired.size()), 0.5 * patch.afferents()) << patch.name;
    }
    // The edge is over a place when its middle is.
    const PatchPlan& sa1 = plan.patches[0];
    for (const Event& event : events) {
        if (event.address >= sa1.first + sa1.afferents()) continue;
        const double middle_mm = -12 + 20 * seconds(event.time);
        EXPECT_LT(std::abs(sa1.places[event.address].x_mm - middle_mm), 0.5 + 0.25 + 3 * 0.5 + 0.1)
            << "an SA1 afferent fires only while the edge is in its field";
    }
}

}  // namespace
}  // namespace afferent
