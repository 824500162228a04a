// Stimuli that touch the skin.
#include "afferent/nodes/stimulus_source.hpp"

#include <gtest/gtest.h>

#include <map>
#include <numbers>
#include <set>

#include "afferent/nodes/run.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

constexpr const char* quiet = "record { force: false picture: false } ";

Plan skin_under(const std::string& stimuli, const std::string& sensor = "", const std::string& patch = "") {
    return make_plan(
        Scene::from_text("duration_s: 0.5 patch { name: 'skin' outline { rectangle { width_mm: 10 height_mm: "
                         "4 } pitch_mm: 0.5 centre { x_mm: 20 y_mm: -30 } } " +
                         patch + " sensor { rate_hz: 1000 full_scale_n: 0.1 adc_bits: 24 " + sensor +
                         " } } source { " + stimuli + " } " + quiet));
}

Plan skin_under_edge(const std::string& edge, const std::string& sensor = "", const std::string& patch = "") {
    Scene scene = skin_under("edge { " + edge + " }", sensor, patch).scene;
    scene.patches[0].outline->centre = {};
    return make_plan(scene);
}

struct Touched {
    TimePoint time;
    std::map<std::uint32_t, double> forces_n;
};

// What the elements are told up to a time, scan by scan.
std::vector<Touched> touched_until(StimulusSource& source, TimePoint until) {
    std::vector<Touched> all;
    for (auto due = source.next(); due && due->time <= until; due = source.next()) {
        const auto scan = source.take(0);
        if (!scan) {
            ADD_FAILURE() << source.refusal().text;
            break;
        }
        if (all.empty() || all.back().time != scan->time) all.push_back({scan->time, {}});
        for (std::size_t i = 0; i < scan->forces_n.size(); ++i)
            all.back().forces_n[scan->first + static_cast<std::uint32_t>(i)] = scan->forces_n[i];
    }
    EXPECT_FALSE(all.empty()) << "no element has been sampled";
    return all;
}

// What the apertures of all elements add up to, and more than 160 readings of 24 bits.
constexpr double as_exact_as_apertures = 1e-4;

// Hertz: a line contact carries π/2 · a · peak for each millimetre of its length, here the patch's height.
TEST(StimulusSource, PressesWithTheForceOfALineContact) {
    for (const char* direction : {"", "direction_deg: 180 "}) {
        const Plan plan = skin_under_edge(std::string(direction) +
                                          "speed_mm_per_s: 20 begin_mm: -3 half_width_mm: 0.8 peak_kpa: 30");
        StimulusSource source(plan);
        for (const Touched& scan : touched_until(source, scene_start + 250ms)) {
            double sum_n = 0;
            for (const auto& [element, force_n] : scan.forces_n) sum_n += force_n;
            const double expected_n = std::numbers::pi / 2 * 0.8 * 0.03 * 4;
            EXPECT_NEAR(sum_n, expected_n, as_exact_as_apertures * expected_n);
        }
    }
}

TEST(StimulusSource, MovesAtItsSpeedAlongItsDirection) {
    const Plan plan = skin_under_edge("direction_deg: 90 speed_mm_per_s: 10 begin_mm: -2 half_width_mm: 0.6");
    StimulusSource source(plan);
    const ElementGrid& grid = *plan.patches[0].grid;
    for (const Touched& scan : touched_until(source, scene_start + 350ms)) {
        double sum_n = 0;
        double moment = 0;
        for (const auto& [element, force_n] : scan.forces_n) {
            sum_n += force_n;
            moment += force_n * grid.place(element).y_mm;
        }
        const double middle_mm = -2 + 10 * seconds(scan.time);
        if (std::abs(middle_mm) > 0.15) continue;  // a part of it is felt beyond the skin
        EXPECT_NEAR(moment / sum_n, middle_mm, 0.001);
    }
}

// After the first scan, only elements that the edge touches or has just left are sampled.
TEST(StimulusSource, LeavesUntouchedSkinAlone) {
    const Plan plan = skin_under_edge("speed_mm_per_s: 20 begin_mm: -8 half_width_mm: 0.5");
    StimulusSource source(plan);
    const auto scans = touched_until(source, plan.end());
    ASSERT_GT(scans.size(), 100U);
    EXPECT_EQ(scans.front().forces_n.size(), plan.elements);
    EXPECT_EQ(scans[1].time, scene_start + 1ms) << "a slope ends one sample after its force";
    // From -8 mm to the first element at -4.75 less the reach of the edge, 0.5 mm and 2.5 pitches, it takes
    // 75 ms.
    const auto later = std::find_if(scans.begin(), scans.end(),
                                    [](const Touched& scan) { return scan.time > scene_start + 10ms; });
    ASSERT_NE(later, scans.end());
    EXPECT_NEAR(seconds(later->time), 0.075, 0.0011) << "a sample at most later";
    std::size_t samples = 0;
    for (auto scan = later; scan != scans.end(); ++scan) {
        EXPECT_LE(scan->forces_n.size(), 8U * 8U) << "8 rows of 7 elements, and one that has been left";
        samples += scan->forces_n.size();
    }
    EXPECT_EQ(source.samples(), samples + static_cast<std::size_t>(later - scans.begin()) * plan.elements);
}

// An encoder with lags goes on being told until it has settled: the drive ends where it began.
TEST(StimulusSource, SamplesUntilTheEncodersHaveSettled) {
    const Plan plan = skin_under_edge("speed_mm_per_s: 100 begin_mm: -6 half_width_mm: 0.5", "",
                                      "encoder { vibration { gain_mv_s2_per_n: 1 corner_hz: 100 } }");
    StimulusSource source(plan);
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
    for (const auto& [element, drive_mv] : last) {
        EXPECT_GT(largest[element], 0) << element << ": the edge crosses every element";
        EXPECT_LE(drive_mv, 1e-8 * largest[element]) << element;
    }
}

// The edge has left the skin after 130 ms, and a vibration of 100 Hz has settled some 50 ms later.
TEST(StimulusSource, SamplesNothingOnceTheEncodersHaveSettled) {
    const Plan plan = skin_under_edge("speed_mm_per_s: 100 begin_mm: -6 half_width_mm: 0.5", "",
                                      "encoder { vibration { gain_mv_s2_per_n: 1 corner_hz: 100 } }");
    StimulusSource source(plan);
    const TimePoint last = touched_until(source, plan.end() - 1ms).back().time;
    EXPECT_GT(seconds(last), 0.13);
    EXPECT_LT(seconds(last), 0.25);
}

// The skin does not reach into such deep grooves, so that the force falls to the part of the surface that is
// ridge.
TEST(StimulusSource, SlidesRidgesOfTheirWidthOverGroovesOfTheirDepth) {
    const auto pressed_n = [](const std::string& grating) {
        const Plan plan = skin_under(
            "grating { speed_mm_per_s: 0 period_mm: 0.5 pad { x_mm: 20 y_mm: -30 width_mm: 8 height_mm: 3 "
            "peak_kpa: 20 } " +
            grating + " }");
        StimulusSource source(plan);
        const std::vector<Touched> scans = touched_until(source, scene_start + 300ms);
        double force_n = 0;
        if (!scans.empty())
            for (const auto& [element, reads_n] : scans.front().forces_n) force_n += reads_n;
        return force_n;
    };
    const double flat_n = pressed_n("ridge_mm: 0.1 depth_mm: 0");
    ASSERT_GT(flat_n, 0);
    EXPECT_NEAR(pressed_n("ridge_mm: 0.1 depth_mm: 5") / flat_n, 0.2, 0.01);
    EXPECT_NEAR(pressed_n("ridge_mm: 0.4 depth_mm: 5") / flat_n, 0.8, 0.01);
}

TEST(StimulusSource, SamplesAllElementsOfNoisySensors) {
    const Plan plan = skin_under_edge("begin_mm: -100", "noise_counts: 0.5");
    StimulusSource source(plan);
    for (const Touched& scan : touched_until(source, scene_start + 20ms))
        EXPECT_EQ(scan.forces_n.size(), plan.elements);
    EXPECT_EQ(source.samples(), 21U * plan.elements);
}

TEST(StimulusSource, RefusesWhatIsBeyondFullScaleWhereTheSceneSaysSo) {
    const Plan plan = skin_under_edge("peak_kpa: 1e4 begin_mm: 0", "out_of_range: REFUSE");
    StimulusSource source(plan);
    while (source.take(0)) {
        ASSERT_TRUE(source.next());
        ASSERT_LE(source.next()->time, plan.end());
    }
    EXPECT_NE(source.refusal().text.find("patch \"skin\": the stimuli press an element beyond full scale"),
              std::string::npos);
}

// ---- indenters and others ----

constexpr double one_count_n = 0.1 / (1 << 24);

double total_n(const Touched& scan) {
    double sum_n = 0;
    for (const auto& [element, force_n] : scan.forces_n) sum_n += force_n;
    return sum_n;
}

// The whole load reaches the elements, on the map and not only in the patch's own coordinates.
TEST(StimulusSource, PressesWithTheLoadOfAnIndenter) {
    for (const char* tip : {"FLAT", "SPHERE"}) {
        const Plan plan = skin_under("indenter { x_mm: 18.3 y_mm: -29.9 radius_mm: 1 force_n: 0.15 tip: " +
                                     std::string(tip) + " press { begin_s: 0.1 rise_s: 0.1 } }");
        StimulusSource source(plan);
        const auto scans = touched_until(source, plan.end());
        ASSERT_FALSE(scans.empty());
        for (const Touched& scan : scans) {
            const double load = std::clamp((seconds(scan.time) - 0.1) / 0.1, 0.0, 1.0);
            EXPECT_NEAR(total_n(scan), 0.15 * load, as_exact_as_apertures * 0.15);
        }
        EXPECT_EQ(scans.back().time, plan.end());
    }
}

// Untouched skin is not sampled at all, but once before it is pressed: encoders take the force to change
// along the straight line from one sample to the next.
TEST(StimulusSource, BeginsOneSampleAheadOfTheForce) {
    const Plan plan =
        skin_under("indenter { x_mm: 20 y_mm: -30 tip: FLAT press { begin_s: 0.1 hold_s: 0.2 } }");
    StimulusSource source(plan);
    const auto scans = touched_until(source, plan.end());
    ASSERT_GE(scans.size(), 2U);
    EXPECT_EQ(scans[0].time, scene_start + 99ms);
    EXPECT_EQ(total_n(scans[0]), 0);
    EXPECT_EQ(scans[0].forces_n.size(), scans[1].forces_n.size());
    EXPECT_GT(total_n(scans[1]), 0.09);
    EXPECT_EQ(scans.back().time, scene_start + 302ms) << "the drive of a force settles in two samples";
    EXPECT_EQ(total_n(scans.back()), 0);
    for (const Touched& scan : scans) EXPECT_LE(scan.forces_n.size(), 8U * 10U) << "a radius of 1 mm";
}

TEST(StimulusSource, SamplesOnceWhatDoesNotReadZeroAtRest) {
    const Plan plan = skin_under("indenter { x_mm: 1000 }", "stuck_element { element: 7 force_n: 0.02 }");
    StimulusSource source(plan);
    const auto scans = touched_until(source, plan.end());
    ASSERT_EQ(scans.size(), 2U);
    EXPECT_EQ(scans[0].forces_n.size(), plan.elements);
    EXPECT_EQ(scans[0].forces_n.at(7), 0.02);
}

// The first slope of a fast stimulus is that of its force, not of the time since the scene began.
TEST(StimulusSource, TellsEncodersTheWholeSlope) {
    const Plan plan =
        skin_under("indenter { x_mm: 20 y_mm: -30 force_n: 0.1 press { begin_s: 0.2 rise_s: 0.01 } }", "",
                   "encoder { transient { gain_mv_s_per_n: 1 } }");
    StimulusSource source(plan);
    Transient encoder({.gain_mv_s_per_n = 1, .bias_mv = 0});
    std::map<std::uint32_t, Transient::State> states;
    int rising = 0;
    for (const Touched& scan : touched_until(source, scene_start + 206ms)) {
        double slope_n_per_s = 0;
        for (const auto& [element, force_n] : scan.forces_n)
            slope_n_per_s += encoder.drive_mv(states[element], scan.time, force_n);
        if (scan.time <= scene_start + 200ms) continue;
        ++rising;
        // A growing contact takes force from no element. The readings are rounded to counts.
        EXPECT_NEAR(slope_n_per_s, 0.1 / 0.01, 100 * one_count_n * 1000 + as_exact_as_apertures * 10)
            << seconds(scan.time);
    }
    EXPECT_EQ(rising, 6) << "at 1 kHz, up to 206 ms";
}

TEST(StimulusSource, AddsUpStimuli) {
    const std::string first = "indenter { x_mm: 18.4 y_mm: -30 force_n: 0.05 } ";
    const std::string second = "grating { pad { x_mm: 21 y_mm: -30 width_mm: 5 height_mm: 3 } } ";
    const auto forces = [](const std::string& stimuli) {
        const Plan plan = skin_under(stimuli);
        StimulusSource source(plan);
        return touched_until(source, scene_start + 300ms);
    };
    const auto at = [](const Touched& scan, std::uint32_t element) {
        const auto found = scan.forces_n.find(element);
        return found == scan.forces_n.end() ? 0.0 : found->second;
    };
    const auto both = forces(first + second);
    const auto one = forces(first);
    const auto other = forces(second);
    ASSERT_EQ(both.size(), other.size());
    ASSERT_EQ(both.size(), one.size());
    for (std::size_t i = 0; i < both.size(); i += 10)
        for (const auto& [element, force_n] : both[i].forces_n)
            EXPECT_NEAR(force_n, at(one[i], element) + at(other[i], element), 2 * one_count_n);
    // In any order.
    const auto swapped = forces(second + first);
    ASSERT_EQ(swapped.size(), both.size());
    for (std::size_t i = 0; i < both.size(); ++i) EXPECT_EQ(swapped[i].forces_n, both[i].forces_n);
}

// What a patch feels does not depend on which others there are, and a stimulus slides from one to the next.
// A patch 40 mm away, from which a wave is 5 ms away at 8 m/s.
TEST(StimulusSource, SendsWavesToSkinAwayFromAnIndenterIfAsked) {
    const std::string press =
        "indenter { x_mm: -20 y_mm: -30 force_n: 1 press { begin_s: 0.1 hold_s: 0.2 } } ";
    const Plan still = skin_under(press);
    EXPECT_GT(StimulusSource(still).next().value().time, still.end());
    const Plan plan = skin_under(press + "skin { wave { speed_m_per_s: 8 } }");
    StimulusSource source(plan);
    double before_n = 0;
    double during_n = 0;
    for (const Touched& scan : touched_until(source, scene_start + 300ms)) {
        EXPECT_EQ(scan.forces_n.size(), 160U) << "all that are within its reach";
        for (const auto& [element, force_n] : scan.forces_n)
            (scan.time < scene_start + 104ms ? before_n : during_n) =
                std::max(scan.time < scene_start + 104ms ? before_n : during_n, force_n);
    }
    EXPECT_EQ(before_n, 0);
    EXPECT_GT(during_n, 1e-6);
}

TEST(StimulusSource, CrossesPatchesOnTheMap) {
    const auto forces_of = [](const std::string& patches, const std::string& name) {
        const Plan plan = make_plan(Scene::from_text(
            "duration_s: 1 every_patch { outline { rectangle { width_mm: 10 height_mm: 10 } } sensor { "
            "rate_hz: 500 adc_bits: 24 full_scale_n: 1 } } " +
            patches + "source { indenter { x_mm: -8 speed_mm_per_s: 20 radius_mm: 2 force_n: 0.5 } } " +
            quiet));
        const PatchPlan& patch = found_or_throw(plan.patches, name, &PatchPlan::name);
        StimulusSource source(plan);
        std::vector<std::pair<TimePoint, double>> forces;
        for (const Touched& scan : touched_until(source, plan.end())) {
            double sum_n = 0;
            for (const auto& [element, force_n] : scan.forces_n)
                if (element >= patch.first_element && element < patch.first_element + patch.elements())
                    sum_n += force_n;
            if (sum_n > 0) forces.emplace_back(scan.time, sum_n);
        }
        return forces;
    };
    const std::string left = "patch { name: 'left' outline { centre { x_mm: -5 } } } ";
    const std::string right = "patch { name: 'right' outline { centre { x_mm: 5 } } } ";
    const auto alone = forces_of(right, "right");
    ASSERT_FALSE(alone.empty());
    EXPECT_EQ(forces_of(left + right, "right"), alone);
    EXPECT_EQ(forces_of(right + left, "right"), alone);
    const auto before = forces_of(left + right, "left");
    ASSERT_FALSE(before.empty());
    EXPECT_EQ(before.front().first, scene_start);
    // Its middle is at the border after 400 ms, and it is felt as far as 4.8 mm from there.
    EXPECT_LT(before.back().first, scene_start + 620ms) << "it has left the left one";
    EXPECT_GT(alone.front().first, scene_start + 180ms);
    const auto most = std::max_element(alone.begin(), alone.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    EXPECT_NEAR(most->second, 0.5, as_exact_as_apertures * 0.5)
        << "between its borders it bears the whole load";
}

// What a contact takes leaves the rest to those without a share, in equal parts.
TEST(StimulusSource, SharesTheGripAmongItsContacts) {
    const Plan plan = make_plan(Scene::from_text(
        "duration_s: 1 every_patch { kinds: SA1 outline { rectangle { width_mm: 30 height_mm: 30 } } sensor "
        "{ "
        "rate_hz: 100 adc_bits: 24 full_scale_n: 1 } } patch { name: 'a' } patch { name: 'b' outline { "
        "centre "
        "{ x_mm: 100 } } } source { grasp { point { time_s: 0.2 } point { time_s: 0.4 force_n: 5 } contact { "
        "patch: 'a SA1' share: 0.4 } contact { patch: 'b SA1' x_mm: -3 } contact { x_mm: 104 } } "
        "} " +
        std::string(quiet)));
    StimulusSource source(plan);
    for (const Touched& scan : touched_until(source, plan.end())) {
        // From 0 at 0.2 s to 5 N at 0.4 s.
        const double grip_n = 25 * std::clamp(seconds(scan.time) - 0.2, 0.0, 0.2);
        EXPECT_NEAR(source.true_force_n(scan.time).value(), grip_n, 1e-12);
        double of_a = 0;
        double of_b = 0;
        for (const auto& [element, force_n] : scan.forces_n)
            (element < plan.patches[1].first_element ? of_a : of_b) += force_n;
        EXPECT_NEAR(of_a, 0.4 * grip_n, as_exact_as_apertures * 5) << seconds(scan.time);
        EXPECT_NEAR(of_b, 0.6 * grip_n, as_exact_as_apertures * 5) << seconds(scan.time);
    }
}

// The skin has rows of 20 elements, half a millimetre wide, around (20, -30).
TEST(StimulusSource, PutsAContactWhereItIsOnItsPatchOrOnTheMap) {
    for (const char* const contact : {"patch: 'skin' x_mm: 2 y_mm: 0.5", "x_mm: 22 y_mm: -29.5"}) {
        const Plan plan = skin_under("grasp { point { force_n: 0.05 } contact { radius_mm: 0.5 " +
                                     std::string(contact) + " } }");
        StimulusSource source(plan);
        const Touched last = touched_until(source, scene_start + 300ms).back();
        double sum_n = 0, x_mm = 0, y_mm = 0;
        for (const auto& [element, force_n] : last.forces_n) {
            sum_n += force_n;
            x_mm += force_n * ((element % 20 + 0.5) / 2 - 5);
            y_mm += force_n * ((element / 20 + 0.5) / 2 - 2);
        }
        EXPECT_NEAR(sum_n, 0.05, 1e-3) << contact;
        EXPECT_NEAR(x_mm / sum_n, 2, 0.02) << contact;
        EXPECT_NEAR(y_mm / sum_n, 0.5, 0.02) << contact;
    }
}

TEST(StimulusSource, NeedsStimuliThatCanBe) {
    const auto why = [](const std::string& source) {
        try {
            skin_under(source);
        } catch (const SceneError& error) {
            return std::string(error.what());
        }
        return std::string("accepted");
    };
    for (const auto& [source, expected] : std::vector<std::pair<std::string, std::string>>{
             {"skin { modulus_kpa: 20 }", "source has no stimulus"},
             {"edge {} pushed {}",
              "1:194: source: samples come either from stimuli on the skin or from elsewhere"},
             {"grating { ridge_mm: 3 }", "source.grating[0]"},
             {"grating { ridge_mm: 3 }", "ridge_mm must be at most period_mm"},
             {"indenter {} texture {} texture { longest_mm: 40 }",
              "texture[1].longest_mm must be at most 32 times"},
             {"texture { longest_mm: 0.1 }", "shortest_mm must be at most longest_mm"},
             {"grasp { contact {} }", "grasp[0].point must be given at least once"},
             {"grasp { point {} }", "contact must be given at least once"},
             {"grasp { point {} contact { patch: 'thumb' } }", "must be the name of a patch, is \"thumb\""},
             {"grasp { point {} contact { share: 0.75 } contact { share: 0.5 } }",
              "at most 1 in all, is 1.25"},
             {"indenter { radius_mm: 0 }", "indenter[0].radius_mm must be 0.001 to 1000, is 0"},
         })
        EXPECT_NE(why(source).find(expected), std::string::npos) << source << "\n" << why(source);
}

// SA1 fire under the edge, RA and PC at its borders; the edge has come and gone.
TEST(StimulusSource, DrivesTheFingertip) {
    const Plan plan = make_plan(Scene::from_file(AFFERENT_SOURCE_DIR "/examples/fingertip.txtpb"));
    EXPECT_NEAR(plan.addresses, 250, 15);
    std::vector<Event> events;
    Observer output;
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
