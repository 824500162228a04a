// Afferents that adapt for seconds. docs/afferents.md has the table that this test computes.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "afferent/engine/coprocessor.hpp"
#include "afferent/scene/patch.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

constexpr double times_s[] = {1, 3, 10, 30};

// The rates of an SA1 around those times after a force has come to a square millimetre, from the intervals
// that lie in the second around.
std::vector<double> rates_in_a_hold(double force_n, bool adapts) {
    Scene scene;
    scene.patches = {scene::preset(scene::Kind::sa1)};
    scene::Patch& patch = scene.patches[0];
    patch.name = "skin";
    patch.spread = {};
    patch.outline = scene::Outline{.shape = scene::Rectangle{2, 2}, .pitch_mm = 1};
    patch.afferents->place = {{0, 0}};
    if (adapts) std::get<scene::Sustained>(patch.encoder).slow_adaptation.emplace();
    scene.source = scene::Pushed();
    scene.record = {.events = true, .force = false, .picture = false};
    Coprocessor coprocessor(scene);
    std::vector<double> spikes_s;
    for (TimePoint time = scene_start; time < scene_start + 31s; time += 5ms) {
        coprocessor.push({time, 0, std::vector(4, force_n)});
        for (const Event& event : coprocessor.advance(time + 5ms - 1ns))
            spikes_s.push_back(seconds(event.time));
    }
    std::vector<double> rates_hz;
    for (const double time_s : times_s) {
        const auto first = std::lower_bound(spikes_s.begin(), spikes_s.end(), time_s - 0.5);
        const auto last = std::prev(std::upper_bound(first, spikes_s.end(), time_s + 0.5));
        rates_hz.push_back(static_cast<double>(last - first) / (*last - *first));
    }
    return rates_hz;
}

TEST(SlowAdaptation, TakesTheRateOfAHoldToThatOfWhatIsLeftOfTheForce) {
    const std::vector<double> without = rates_in_a_hold(0.05, false);
    const std::vector<double> with = rates_in_a_hold(0.05, true);
    std::ostringstream rows;
    rows.precision(1);
    rows << std::fixed << "| without, Hz |";
    for (const double rate_hz : without) rows << ' ' << rate_hz << " |";
    rows << "\n| `slow_adaptation {}`, Hz |";
    for (const double rate_hz : with) rows << ' ' << rate_hz << " |";
    std::ifstream in(AFFERENT_SOURCE_DIR "/docs/afferents.md");
    const std::string documented{std::istreambuf_iterator<char>(in), {}};
    EXPECT_NE(documented.find(rows.str()), std::string::npos) << rows.str();
    for (std::size_t i = 0; i < with.size(); ++i) {
        const double left = 1 - 0.3 * (1 - std::exp(-times_s[i] / 8));
        EXPECT_NEAR(with[i] / rates_in_a_hold(0.05 * left, false)[i], 1, 0.02) << times_s[i];
        EXPECT_NEAR(without[i] / without[3], 1, 0.02);
    }
}

}  // namespace
}  // namespace afferent
