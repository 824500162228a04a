#include "afferent/decoders/force_belief.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace afferent {
namespace {

using Belief = ForceBelief;

Belief told(const Belief::Parameters& parameters, double force_n, int times = 200) {
    Belief belief(parameters, 50);
    for (int i = 0; i < times; ++i) {
        belief.predict(0.005);
        belief.measure(force_n, {}, 1e-4);
    }
    return belief;
}

TEST(ForceBelief, WhatIsMeasuredOftenIsBelieved) {
    const Belief belief = told({}, 7);
    EXPECT_NEAR(belief.mean_n(), 7, 0.01);
    EXPECT_LT(belief.variance_n2(), 1e-4);
    EXPECT_LT(belief.at_rest(), 1e-3);
}

// At first a force in motion is 0 give or take half of the largest.
TEST(ForceBelief, RestHasTheWeightThatItIsGiven) {
    for (const double rest : {0.0, 0.5, 0.97}) {
        Belief belief(Belief::Parameters(), 50);
        belief.presume_rest(rest);
        const double second_moment = belief.variance_n2() + belief.mean_n() * belief.mean_n();
        EXPECT_NEAR(second_moment, (1 - rest) * 25 * 25, 1e-9) << rest;
    }
    EXPECT_NEAR(Belief(Belief::Parameters(), 50).at_rest(), 0.97, 1e-12);
}

TEST(ForceBelief, AMotionThatIsLeftBecomesAnother) {
    for (std::size_t from = 0; from < Belief::motions; ++from) {
        double sum = 0;
        for (const double part : Belief::becomes[from]) sum += part;
        EXPECT_NEAR(sum, 1, 1e-12) << from;
        EXPECT_EQ(Belief::becomes[from][from], 0);
    }
}

TEST(ForceBelief, ARampIsFollowedThroughItsLag) {
    Belief belief(Belief::Parameters(), 50);
    const double lag_s = 0.006;
    double force_n = 0;
    for (int i = 0; i < 200; ++i) {
        force_n = 2 + 20 * 0.005 * i;
        belief.predict(0.005);
        belief.measure(force_n - 20 * lag_s, {lag_s}, 1e-4);
    }
    EXPECT_NEAR(belief.mean_n(), force_n, 0.05);
    // The rates of motions that are soon over fall behind.
    EXPECT_NEAR(belief.of_speed().mean_n, 20, 4);
}

TEST(ForceBelief, TimeWidensIt) {
    Belief belief = told({}, 7);
    double before = belief.variance_n2();
    for (int i = 0; i < 5; ++i) {
        belief.predict(0.02);
        EXPECT_GT(belief.variance_n2(), before);
        before = belief.variance_n2();
    }
}

TEST(ForceBelief, StaysAsItIsWhereNoTimePasses) {
    const Belief fresh(Belief::Parameters(), 50);
    for (const double step_s : {0.0, -1.0, std::nan("")}) {
        Belief belief = fresh;
        belief.predict(step_s);
        EXPECT_TRUE(belief == fresh) << step_s;
    }
}

// Also where a motion is left for certain.
TEST(ForceBelief, IsFiniteAfterAnyStep) {
    Belief::Parameters restless;
    for (ForceMotion& motion : restless.motion) motion.leaves_per_s = 1e3;
    for (const Belief::Parameters& parameters : {Belief::Parameters(), restless})
        for (const double step_s : {1e-9, 1e-3, 1.0, 1e6}) {
            Belief belief = told(parameters, 7);
            belief.predict(step_s);
            EXPECT_TRUE(std::isfinite(belief.mean_n()));
            EXPECT_TRUE(std::isfinite(belief.variance_n2()));
        }
}

TEST(ForceBelief, AReleaseComesDownToZeroAndNotBelow) {
    Belief belief = told({}, 8);
    for (double force_n = 8; force_n > 4; force_n -= 0.5) {
        belief.predict(0.005);
        belief.measure(force_n, {}, 1e-4);
    }
    double before = belief.mean_n();
    for (int i = 0; i < 60; ++i) {
        belief.predict(0.01);
        belief.bound(20, {});
        EXPECT_LT(belief.mean_n(), before + 0.05);
        EXPECT_GE(belief.mean_n(), 0);
        before = belief.mean_n();
    }
    EXPECT_LT(before, 2);
    EXPECT_GT(belief.at_rest(), 0.5);
}

TEST(ForceBelief, ABoundTakesAwayWhatIsAbove) {
    Belief belief = told({}, 7);
    belief.predict(0.1);
    const double variance_n2 = belief.variance_n2();
    belief.bound(7, {});
    EXPECT_LT(belief.mean_n(), 7);
    EXPECT_LT(belief.variance_n2(), variance_n2);
}

TEST(ForceBelief, ABoundThatContradictsWhatIsMeasuredDoesNotEndTheGrip) {
    Belief belief = told({}, 7);
    for (int i = 0; i < 10; ++i) {
        belief.predict(0.005);
        belief.measure(7, {}, 1e-4);
        belief.bound(3, {});
    }
    EXPECT_NEAR(belief.mean_n(), 7, 0.2);
}

TEST(ForceBelief, TheSizeOfASpeedTakesTheSignOfTheMotion) {
    for (const double direction : {1.0, -1.0}) {
        Belief belief(Belief::Parameters(), 50);
        for (int i = 0; i < 100; ++i) {
            belief.predict(0.005);
            belief.measure(10 + direction * 0.05 * i, {}, 1e-4);
        }
        belief.predict(0.02);
        belief.measure_speed(30, 0, 1);
        const double before_n = belief.mean_n();
        belief.predict(0.005);
        EXPECT_GT(direction * (belief.mean_n() - before_n), 0.05);
    }
}

TEST(ForceBelief, AForceThatHardlyFallsIsNotBeingReleased) {
    Belief belief = told({}, 8);
    for (double force_n = 8; force_n > 6; force_n -= 0.1) {
        belief.predict(0.005);
        belief.measure(force_n, {}, 0.25);
    }
    Belief held = belief;
    held.bound_speed_below(-1);
    EXPECT_GT(belief.of_speed().mean_n, 15);
    EXPECT_LT(held.of_speed().mean_n, 0.8 * belief.of_speed().mean_n);
    belief.predict(0.05);
    held.predict(0.05);
    EXPECT_GT(held.mean_n(), belief.mean_n() + 0.3);
}

// Every motion that is likely at all rises at about 20 N/s: that it does not fall is known already.
TEST(ForceBelief, ARisingForceLearnsNothingFromABoundOnItsFall) {
    Belief belief = told({}, 2);
    for (double force_n = 2; force_n < 6; force_n += 0.1) {
        belief.predict(0.005);
        belief.measure(force_n, {}, 1e-4);
    }
    Belief bounded = belief;
    bounded.bound_speed_below(-10);
    EXPECT_NEAR(bounded.of_speed().mean_n, belief.of_speed().mean_n, 0.01);
    EXPECT_NEAR(bounded.at_rest(), belief.at_rest(), 0.01 * belief.at_rest());
}

TEST(ForceBelief, AMisfitIsASquareOfStandardDeviations) {
    const Belief belief = told({}, 7);
    EXPECT_LT(belief.misfit(7, {}, 1e-4), 1);
    EXPECT_GT(belief.misfit(9, {}, 1e-4), 25);
    EXPECT_LT(belief.misfit(9, {}, 4), 2);
}

TEST(ForceBelief, AForceBeyondFullScaleIsNoLessThanThat) {
    Belief belief = told({}, 7);
    belief.predict(0.1);
    belief.bound_below(9, {});
    EXPECT_GT(belief.mean_n(), 9);
    Belief sure = told({}, 12);
    const double before_n = sure.mean_n();
    sure.bound_below(9, {});
    EXPECT_NEAR(sure.mean_n(), before_n, 1e-6);
}

// Elements of 1/2, 1/4 and 1/4 that read 8, 10 and 6 N: together 8 N.
class WithElements : public testing::Test {
  protected:
    void SetUp() override {
        for (int i = 0; i < 400; ++i) {
            belief.predict(0.005);
            for (std::uint32_t element = 0; element < 3; ++element)
                belief.measure(reads_n[element], {0, element}, 1e-4, 3);
        }
    }
    static constexpr double reads_n[] = {8, 10, 6};
    Belief belief{Belief::Parameters(), ElementSpread{{0.5, 0.25, 0.25}, 0.01, 0.01, 1}, 50};
};

TEST_F(WithElements, TheForceIsWhatTheyReadInAll) {
    EXPECT_NEAR(belief.mean_n(), 8, 0.05);
    EXPECT_NEAR(belief.of_element(0).mean_n, 0, 0.01);
    EXPECT_NEAR(belief.of_element(1).mean_n, 0.25, 0.01);
    EXPECT_NEAR(belief.of_element(2).mean_n, -0.25, 0.01);
    for (std::uint32_t element = 0; element < 3; ++element) {
        EXPECT_GT(belief.of_element(element).variance_n2, 0) << "it is not known exactly";
        EXPECT_LT(belief.of_element(element).variance_n2, 0.005) << "a quarter of what it was";
    }
}

TEST_F(WithElements, AnExcludedOneMakesUpNoForce) {
    belief.exclude(1);
    // (8 · 1/2 + 6 · 1/4) / (3/4)
    EXPECT_NEAR(belief.mean_n(), 22.0 / 3, 0.05);
    EXPECT_NEAR(belief.of_past({0, 2}).mean_n, 6, 0.05) << "what another reads stays";
    belief.include(1);
    for (int i = 0; i < 400; ++i) {
        belief.predict(0.005);
        for (std::uint32_t element = 0; element < 3; ++element)
            belief.measure(reads_n[element], {0, element}, 1e-4, 3);
    }
    EXPECT_NEAR(belief.mean_n(), 8, 0.05);
}

// In the long run the departures are as they are stated, but for their part that is a change of the force:
// with shares s_i of 2/3 and 1/3, once the other is excluded, a variance of (1 − 2 s_i + Σ s²) of 0.02.
TEST_F(WithElements, ThoseThatRemainDepartFromTheMeanOfTheirs) {
    belief.exclude(1);
    for (int i = 0; i < 2000; ++i) belief.predict(0.1);
    EXPECT_NEAR(belief.of_element(0).variance_n2, 0.02 * 2 / 9, 1e-5);
    EXPECT_NEAR(belief.of_element(2).variance_n2, 0.02 * 8 / 9, 1e-5);
}

TEST(ForceBelief, IsThatOfItsShares) {
    const Belief one{Belief::Parameters(), ElementSpread{{0.5, 0.25, 0.25}, 0, 0, 1}, 50};
    const Belief other{Belief::Parameters(), ElementSpread{{0.25, 0.5, 0.25}, 0, 0, 1}, 50};
    EXPECT_NE(one, other);
    EXPECT_EQ(one, Belief(one));
}

TEST(ForceBelief, IsReleasingWithAPartOfWhatIsNotRest) {
    Belief belief{Belief::Parameters(), ElementSpread{}, 50};
    belief.presume_rest(0.5);
    const double releasing = belief.releasing();
    EXPECT_GT(releasing, 0);
    belief.presume_rest(0.9);
    EXPECT_NEAR(belief.releasing(), releasing, 1e-12);
}

// There would be nobody left to make up the force.
TEST(ForceBelief, TheOnlyElementIsNotExcluded) {
    Belief belief{Belief::Parameters(), ElementSpread{{1.0}, 0.01, 0.01, 1}, 50};
    for (int i = 0; i < 400; ++i) {
        belief.predict(0.005);
        belief.measure(8, {0, 0}, 1e-4, 3);
    }
    const Belief before = belief;
    belief.exclude(0);
    EXPECT_EQ(belief, before);
    EXPECT_NEAR(belief.mean_n(), 8, 0.1);
}

TEST_F(WithElements, AWidenedOneTakesAChangeForItself) {
    belief.widen(1, 0.25);
    belief.measure(14, {0, 1}, 1e-4);
    // Linear in a change of this size.
    EXPECT_NEAR(belief.of_past({0, 1}).mean_n, 14, 0.4);
    EXPECT_NEAR(belief.of_past({0, 0}).mean_n, 8, 0.2);
    // 8/2 + 14/4 + 6/4
    EXPECT_NEAR(belief.mean_n(), 9, 0.3);
}

}  // namespace
}  // namespace afferent
