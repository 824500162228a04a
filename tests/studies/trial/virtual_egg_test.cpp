// The ordering of conditions on objects that all break at the same force, as docs/trial.md states it.
#include <gtest/gtest.h>

#include <cstdint>
#include <string_view>
#include <vector>

#include "afferent/studies/trial/experiment.hpp"
#include "tests/studies/trial/example_trial.hpp"

namespace afferent {
namespace {

constexpr std::uint32_t eggs = 80;

std::size_t broken_eggs(double breaking_force_n, std::string_view condition) {
    Scene scene = example_trial();
    scene.trial->object.breaking_force_n = breaking_force_n;
    scene.trial->object.breaking_spread = 0;
    scene.trial->object.least_breaking_force_n = 0;
    scene.trial->slippery.part = 0;
    const std::vector<Presentation> presentations = Experiment(scene, condition).present(0, eggs);
    EXPECT_EQ(presentations.size(), eggs);
    std::size_t broken = 0;
    for (const Presentation& each : presentations) {
        EXPECT_EQ(each.breaking_force_n, breaking_force_n);
        broken += each.outcome == Outcome::broken;
    }
    return broken;
}

// At most a third of the differences that docs/trial.md measures over 1,250 eggs.
constexpr std::size_t margin = eggs / 10;

TEST(VirtualEgg, BreaksLessOftenWithFeedbackAtSixNewtons) {
    const std::size_t without = broken_eggs(6, "none");
    EXPECT_LT(broken_eggs(6, "force") + margin, without);
    EXPECT_LT(broken_eggs(6, "rate") + margin, without);
}

TEST(VirtualEgg, BreaksLessOftenAtEighteenNewtonsThanAtSix) {
    for (const std::string_view condition : {"none", "force", "rate"})
        EXPECT_LT(broken_eggs(18, condition) + margin, broken_eggs(6, condition)) << condition;
}

}  // namespace
}  // namespace afferent
