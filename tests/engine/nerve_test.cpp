// Events on their way through nerves.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "afferent/engine/controller.hpp"
#include "afferent/engine/coprocessor.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

constexpr Address with_nerve = 3000;  // and the addresses from there on, on the same elements

// The elements of "a" are felt twice: by afferents beside the coprocessor, and by others 4,950 us away.
Scene felt_twice(const std::string& form, const std::string& threads) {
    return Scene::from_text(
        "every_patch { encoder { sustained { gain_mv_per_n: 40 } } "
        "neuron { delta_g: 0.1 refractory_ms: 2 form: " +
        form +
        " } } patch { name: 'a' elements: 3000 } "
        "patch { name: 'b' elements_of: 'a' nerve { length_mm: 297 speed_m_per_s: 60 } } "
        "source { profile { point {} } } record { force: false picture: false } runtime { threads: " +
        threads + " }");
}

// Pressed for a second, every element otherwise, and then not at all for another.
std::vector<Event> press(Coprocessor& coprocessor, Duration window) {
    std::vector<Event> all;
    std::vector<double> forces_n(with_nerve);
    TimePoint scan = scene_start;
    for (TimePoint until = scene_start + window; until <= scene_start + 2s; until += window) {
        for (; scan < until && scan <= scene_start + 1s; scan += 5ms) {
            for (std::size_t i = 0; i < forces_n.size(); ++i)
                forces_n[i] = scan < scene_start + 1s
                                  ? 1 + std::sin(20 * seconds(scan) + 0.7 * static_cast<double>(i))
                                  : 0;
            coprocessor.push({scan, 0, forces_n});
        }
        const auto events = coprocessor.advance(until);
        all.insert(all.end(), events.begin(), events.end());
    }
    return all;
}

TEST(Nerve, DelaysEachEventByLengthOverSpeed) {
    for (const auto& [form, threads, window] : std::vector<std::tuple<const char*, const char*, Duration>>{
             {"SPARSE", "1", 1ms}, {"SPARSE", "2", 4ms}, {"DENSE", "1", 7ms}, {"AUTO", "2", 500ms}}) {
        SCOPED_TRACE(std::string(form) + ", threads " + threads);
        Coprocessor coprocessor(felt_twice(form, threads));
        const std::vector<Event> events = press(coprocessor, window);
        std::vector<Event> without;
        std::vector<Event> with;
        for (const Event& event : events) {
            if (event.address < with_nerve)
                without.push_back({event.time + 4950us, event.address + with_nerve});
            else
                with.push_back(event);
        }
        EXPECT_GT(without.size(), 10'000U);
        EXPECT_EQ(with, without);
        EXPECT_TRUE(std::ranges::is_sorted(
            events, {}, [](const Event& event) { return std::pair(event.time, event.address); }));
        coprocessor.reset();
        EXPECT_EQ(press(coprocessor, window), events) << "nothing is left under way";
    }
}

TEST(Nerve, LetsNothingArriveBeforeItsTime) {
    Coprocessor coprocessor(
        Scene::from_text("patch { name: 'a' elements: 1 share: 1 encoder { sustained { gain_mv_per_n: 40 } } "
                         "nerve { length_mm: 500 speed_m_per_s: 50 } } source { pushed {} }"));
    coprocessor.push({scene_start, 0, std::vector{2.0}});
    std::vector<Event> arrived;
    for (TimePoint until = scene_start; until <= scene_start + 100ms; until += 1ms)
        for (const Event& event : coprocessor.advance(until)) {
            EXPECT_LE(event.time, until);
            EXPECT_GT(event.time, until - 1ms);
            arrived.push_back(event);
        }
    ASSERT_GT(arrived.size(), 3U);
    EXPECT_GT(arrived.front().time, scene_start + 10ms);
    EXPECT_LT(arrived.front().time, scene_start + 20ms) << "a spike soon after the touch";
}

// What a decoder is told of the nerve makes up for it: the filter expects the present force.
TEST(Nerve, IsMadeUpForByTheFilter) {
    const auto error_n = [](const std::string& nerve, const std::string& told) {
        const std::string text =
            "patch { name: 'a' elements: 3 share: [0.4, 0.3, 0.3] neuron { delta_g: 0.03 } ";
        const std::string rest = " } decoder { filter {} } record { force: true } source { pushed {} }";
        Coprocessor coprocessor(Scene::from_text(text + nerve + rest));
        Controller controller(Scene::from_text(text + told + rest));
        double worst_n = 0;
        for (TimePoint now = scene_start; now < scene_start + 2s; now += 5ms) {
            // Rises by 8 N in a second and a half.
            const double force_n = 8 * std::min(1.0, seconds(now) / 1.5);
            coprocessor.push({now, 0, std::vector{0.4 * force_n, 0.3 * force_n, 0.3 * force_n}});
            controller.observe(now, now + 5ms, coprocessor.advance(now + 5ms - 1ns));
            const double estimate_n = controller.step(now + 5ms, {}).estimate.force_n;
            if (now > scene_start + 500ms && now < scene_start + 1400ms)
                worst_n = std::max(worst_n, force_n - estimate_n);
        }
        return worst_n;
    };
    const std::string nerve = "nerve { length_mm: 1000 speed_m_per_s: 10 }";  // 100 ms: half a newton
    const double without_n = error_n("", "");
    EXPECT_LT(without_n, 0.2);
    EXPECT_NEAR(error_n(nerve, nerve), without_n, 0.1);
    EXPECT_NEAR(error_n(nerve, ""), without_n + 8 / 1.5 * 0.1, 0.15);
}

}  // namespace
}  // namespace afferent
