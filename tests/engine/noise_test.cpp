// Afferents with noise of their own.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "afferent/engine/coprocessor.hpp"
#include "afferent/engine/noisy_drive.hpp"
#include "afferent/scene/patch.hpp"
#include "afferent/scene/plan.hpp"
#include "tests/long_runs.hpp"

namespace afferent {
namespace {

// v of a membrane that the noise alone drives, without a threshold, at the ends of scans.
TEST(Noise, HasThePotentialDeviateByWhatIsStatedAtAnyRate) {
    for (const double rate_hz : {50.0, 200.0, 5000.0}) {
        const Plan plan = make_plan(
            Scene::from_text("patch { name: 'a' neuron { tau_m_ms: 8 noise_mv: 0.7 } sensor { rate_hz: " +
                             std::to_string(rate_hz) + " } } source { pushed {} }"));
        NoisyDrive noise(plan.patches[0].noise);
        noise.set_rest(-1);
        const double decay = std::exp(-1000 / rate_hz / 8);
        double sum = 0;
        double squares = 0;
        std::size_t counted = 0;
        for (Address address = 0; address < 100; ++address) {
            double v_mv = 0;
            for (std::uint64_t i = 0; i < 6000; ++i) {
                v_mv = decay * v_mv + (1 - decay) * noise(0, address, sample_time(i, rate_hz));
                if (i < 1000) continue;
                sum += v_mv;
                squares += v_mv * v_mv;
                ++counted;
            }
        }
        const double mean_mv = sum / static_cast<double>(counted);
        EXPECT_NEAR(mean_mv, 0, 0.03) << rate_hz;
        EXPECT_NEAR(std::sqrt(squares / static_cast<double>(counted) - mean_mv * mean_mv), 0.7, 0.015)
            << rate_hz;
        EXPECT_EQ(noise(-1, 3, scene_start + 1s), -1) << "what nothing drives has none";
    }
}

Scene noisy_skin(const std::string& form, const std::string& threads, const std::string& seed = "1") {
    return Scene::from_text(
        "patch { name: 'a' elements: 3000 encoder { sustained { gain_mv_per_n: 40 } } "
        "neuron { delta_g: 0.1 noise_mv: 1 form: " +
        form + " } } source { profile { point {} } } record { force: false picture: " + "false } seed: " +
        seed + " runtime { threads: " + threads + " }");
}

std::vector<Event> press(const Scene& scene, int scans_at_once) {
    Coprocessor coprocessor(scene);
    std::vector<Event> all;
    for (int scan = 0; scan < 400; ++scan) {
        const TimePoint time = scene_start + scan * 5ms;
        // Held for a second.
        coprocessor.push({time, 0, std::vector(3000, scan < 200 ? 1.0 : 0.0)});
        if ((scan + 1) % scans_at_once != 0) continue;
        const auto events = coprocessor.advance(time + 5ms - 1ns);
        all.insert(all.end(), events.begin(), events.end());
    }
    return all;
}

TEST(Noise, IsTheSameForAnyThreadsAndForms) {
    const std::vector<Event> one = press(noisy_skin("SPARSE", "1"), 1);
    ASSERT_GT(one.size(), 10'000U);
    EXPECT_EQ(press(noisy_skin("SPARSE", "2"), 7), one);
    EXPECT_NE(press(noisy_skin("SPARSE", "1", "2"), 1), one) << "another seed";
    // Each afferent's events, within the nanosecond of a sweep.
    const auto by_address = [](const std::vector<Event>& events) {
        std::vector<std::vector<TimePoint>> times(3000);
        for (const Event& event : events) times[event.address].push_back(event.time);
        return times;
    };
    const auto predicted = by_address(one);
    const auto swept = by_address(press(noisy_skin("DENSE", "1"), 1));
    for (std::size_t i = 0; i < predicted.size(); ++i) {
        ASSERT_EQ(predicted[i].size(), swept[i].size()) << i;
        for (std::size_t k = 0; k < predicted[i].size(); ++k)
            ASSERT_LE(std::abs((predicted[i][k] - swept[i][k]).count()), 1) << i;
    }
    EXPECT_NE(predicted[0], predicted[1]) << "each has its own";
    EXPECT_LT(one.back().time, scene_start + 1005ms) << "untouched, they are silent";
}

TEST(Noise, IsInThePlansBoundOfEvents) {
    const auto bound = [](const std::string& noise) {
        return make_plan(Scene::from_text("patch { name: 'a' elements: 1 share: 1 encoder { sustained { "
                                          "gain_mv_per_n: 40 } } sensor { full_scale_n: 10 } neuron { " +
                                          noise + " } } source { pushed {} }"))
            .events_per_second;
    };
    // 4 standard deviations of a drive that is held for 5 ms, of a membrane of 10 ms.
    const double decay = std::exp(-0.5);
    const double largest_mv = 4 * 2 * std::sqrt((1 + decay) / (1 - decay));
    EXPECT_NEAR(bound("noise_mv: 2"), bound("") * (400 + largest_mv) / 400, 0.03 * bound(""));
    EXPECT_GT(bound("noise_mv: 2"), 1.02 * bound(""));
}

TEST(Noise, IsRefusedWhereNeuronsAreAChips) {
    try {
        make_plan(Scene::from_text("patch { name: 'a' neuron { fixed_point {} noise_mv: 1 } }"));
        ADD_FAILURE() << "accepted";
    } catch (const SceneError& error) {
        EXPECT_NE(std::string(error.what()).find("noise_mv must be 0 where the neuron is fixed_point"),
                  std::string::npos)
            << error.what();
    }
}

// ---- the table of docs/afferents.md ----

struct Held {
    double rate_hz = 0;
    double variation = 0;  // coefficient of variation of intervals
};

// Two hundred SA1 on the same square millimetre, from the second second of a hold of five.
Held hold(double noise_mv, double force_n) {
    Scene scene;
    scene.patches = {scene::preset(scene::Kind::sa1)};
    scene::Patch& patch = scene.patches[0];
    patch.name = "skin";
    patch.spread = {};
    patch.neuron.noise_mv = noise_mv;
    patch.outline = scene::Outline{.shape = scene::Rectangle{2, 2}, .pitch_mm = 1};
    patch.sensor.rate_hz = 1000;
    patch.afferents->place.assign(200, {0, 0});
    // On the sensors' clock, so that the neurons can be swept.
    patch.neuron.form = scene::Form::dense;
    scene.source = scene::Profile{{{.time_s = 0, .force_n = 0}}};
    scene.record = {.events = true, .force = false, .picture = false};
    Coprocessor coprocessor(scene);
    std::vector<TimePoint> last(200);
    double sum = 0;
    double squares = 0;
    double intervals = 0;
    for (TimePoint time = scene_start; time < scene_start + 5s; time += 1ms) {
        coprocessor.push({time, 0, std::vector(4, force_n)});
        for (const Event& event : coprocessor.advance(time + 1ms - 1ns)) {
            if (last[event.address] > scene_start + 1s) {
                const double interval_s = seconds(event.time) - seconds(last[event.address]);
                sum += interval_s;
                squares += interval_s * interval_s;
                ++intervals;
            }
            last[event.address] = event.time;
        }
    }
    const double mean_s = sum / intervals;
    return {1 / mean_s, std::sqrt(std::max(0.0, squares / intervals - mean_s * mean_s)) / mean_s};
}

TEST(Noise, MakesIntervalsOfAHoldIrregular) {
    std::ifstream in(AFFERENT_SOURCE_DIR "/docs/afferents.md");
    const std::string documented{std::istreambuf_iterator<char>(in), {}};
    double before = -1;
    for (const double noise_mv : {0.0, 1.0, 2.0, 4.0, 8.0}) {
        if (!long_runs && noise_mv != 0 && noise_mv != 4) continue;
        std::ostringstream row;
        row << std::defaultfloat << "| " << noise_mv << " |";
        for (const double force_n : {0.015, 0.05, 0.15}) {
            const Held held = hold(noise_mv, force_n);
            row << std::fixed;
            row.precision(1);
            row << ' ' << held.rate_hz << " |";
            row.precision(2);
            row << ' ' << held.variation << " |";
            if (force_n == 0.05) {
                EXPECT_GT(held.variation, before);
                before = held.variation;
            }
        }
        EXPECT_NE(documented.find(row.str()), std::string::npos) << row.str();
    }
}

}  // namespace
}  // namespace afferent
