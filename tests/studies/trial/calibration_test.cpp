#include "afferent/studies/trial/calibration.hpp"

#include <gtest/gtest.h>

#include "afferent/studies/trial/experiment.hpp"
#include "afferent/studies/trial/numbers.hpp"
#include "afferent/studies/trial/published.hpp"
#include "afferent/studies/trial/tally.hpp"

namespace afferent {
namespace {

// Another object and another user, so that there is something to find; the heavy object is left out of it.
Scene uncalibrated() {
    Scene scene = Scene::from_file(AFFERENT_SOURCE_DIR "/examples/trial.txtpb");
    scene.trial->object.stiffness_n_per_mm = 1.5;
    scene.trial->user.aim_n = 5;
    return scene;
}

constexpr std::uint32_t few = 50;

TEST(TrialCalibration, BreaksAsManyAsThePaperInEachOfTwoConditions) {
    std::uint32_t done = 0;
    const auto found =
        calibrate_trial(uncalibrated(), few, [&](std::string_view condition, std::uint32_t more) {
            EXPECT_TRUE(condition == "none" || condition == "force");
            done += more;
            return true;
        });
    ASSERT_TRUE(found);
    ASSERT_TRUE(found->is_reached());
    EXPECT_GT(done, 4 * few);
    for (const CalibratedNumber* number : {&found->stiffness, &found->aim}) {
        ASSERT_NE(find_trial_number(number->path), nullptr) << number->path;
        const TrialNumber& known = *find_trial_number(number->path);
        EXPECT_GT(number->found.parameter, known.low);
        EXPECT_LT(number->found.parameter, known.high);
        EXPECT_GT(number->found.sigma, 0);
        // Rounded to three decimals in the scene.
        EXPECT_NEAR(value_in(found->scene, known), number->found.parameter, 0.0005 + 1e-12);
        // The scene that comes back does what was counted, but for its heavy objects.
        Scene delicate = found->scene;
        delicate.trial->slippery.part = 0;
        const auto presented = Experiment(delicate, number->condition).present(0, few);
        // Rounding the parameter may break one object of fifty more or less.
        const double target = published(number->condition).value().broken.value();
        EXPECT_NEAR(tally(presented).delicate.broken().value(), target, 0.03) << number->path;
    }
    EXPECT_EQ(found->scene.trial->slippery, uncalibrated().trial->slippery);
}

TEST(TrialCalibration, StopsWhereItIsTold) {
    int calls = 0;
    EXPECT_FALSE(calibrate_trial(uncalibrated(), few, [&](std::string_view, std::uint32_t) {
        ++calls;
        return calls < 3;
    }));
    EXPECT_EQ(calls, 3);
}

}  // namespace
}  // namespace afferent
