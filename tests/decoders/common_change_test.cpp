// The common change that transient afferents tell, whose thresholds are known: those that it reaches fire.
#include "afferent/decoders/common_change.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "afferent/runtime/parameter_error.hpp"
#include "tests/since_start.hpp"

namespace afferent {
namespace {

constexpr double held_n_per_mm2 = 0.02;
constexpr double negative_ratio = 0.125;
constexpr std::uint32_t sustained = 9;
constexpr std::uint32_t transient = 18;
// So slow a membrane that the time of a change does not matter.
constexpr double slow_s = 10;

std::vector<SkinField> fields() {
    std::vector<SkinField> all;
    for (std::size_t i = 0; i < sustained; ++i)
        all.push_back({static_cast<double>(i % 3), static_cast<double>(i / 3), 0.25});
    return all;
}

// They lie in the same places, and fire at a fall by 1/9, 2/9, ..., 2 times the pressure that is held.
std::vector<CommonChange::Transient> transients(double told_gain = 1, double tau_m_s = slow_s) {
    std::vector<CommonChange::Transient> all;
    for (std::uint32_t i = 0; i < transient; ++i) {
        const double fall = (i + 1) / 9.0 * held_n_per_mm2 / told_gain;
        all.push_back({sustained + i, fields()[i * 5 % sustained], fall, fall * negative_ratio, tau_m_s});
    }
    return all;
}

// All of them have fired before, and the pressures are held.
CommonChange under_contact(std::vector<CommonChange::Transient> all = transients()) {
    CommonChange change(sustained + transient, fields(), std::move(all));
    for (std::uint32_t i = 0; i < transient; ++i) change.hear(i, at(0ms));
    return change;
}

// Those fire that a fall by that part reaches, one each millisecond.
void fall_by(CommonChange& change, double part) {
    TimePoint time = at(500ms);
    const std::vector<double> held(sustained, held_n_per_mm2);
    for (std::uint32_t i = 0; i < transient; ++i) {
        if (!((i + 1) / 9.0 < part)) continue;
        if (change.begins(time) && change.feels(i, held)) change.begin(time, held, true);
        change.hear(i, time);
        time += 1ms;
    }
}

// As the adaptation of each decays since its last spike, the least pressure that would make it fire does:
// from 1.4 times the one that is held to that.
CommonChange::Sustained silent(std::uint32_t i, double overdue = 1) {
    return {.held = held_n_per_mm2, .at_most = (1 + 0.05 * i) * overdue * held_n_per_mm2};
}

CommonChange::Factor factor(const CommonChange& change, double heard = 1, double overdue = 1) {
    return change.factor(heard, [=](std::uint32_t i) { return silent(i, overdue); });
}

TEST(CommonChange, TellsByHowMuchThePressuresHaveFallen) {
    for (const double part : {0.3, 0.5, 0.7}) {
        CommonChange change = under_contact();
        fall_by(change, part);
        ASSERT_TRUE(change.happened());
        const auto [mean, sigma] = factor(change);
        // Thresholds are a ninth apart, and soft within a quarter of themselves.
        EXPECT_NEAR(mean, 1 - part, 0.12) << part;
        EXPECT_LT(std::abs(mean - (1 - part)), 2 * sigma) << part;
        EXPECT_LT(sigma, 0.25) << part << ": that of any fall, 1/√12, is 0.29";
    }
    CommonChange lifted = under_contact();
    fall_by(lifted, 1);
    EXPECT_LT(factor(lifted).mean, 0.2);
}

TEST(CommonChange, IsNoneWithoutAPressureOrASpike) {
    CommonChange change = under_contact();
    EXPECT_FALSE(change.happened());
    EXPECT_TRUE(change.begins(at(500ms)));
    EXPECT_FALSE(change.feels(0, std::vector<double>(sustained, 0.0)));
    change.begin(at(500ms), std::vector<double>(sustained, held_n_per_mm2), false);
    change.hear(0, at(500ms));
    EXPECT_FALSE(change.happened()) << "not common";
    EXPECT_FALSE(change.begins(at(600ms))) << "not before a pause";
    EXPECT_TRUE(change.begins(at(601ms)));
}

// A transient afferent in the place of a sustained one. The next ones are 1, 1 and √2 mm away and hold
// nothing. Then it feels 1/(1 + 2w + w²) of what that one holds, with w = e^(−1/(2 · 0.6²)).
TEST(CommonChange, IsFeltAsTheSustainedAfferentsAroundHoldIt) {
    const auto fallen = [](std::vector<double> held) {
        CommonChange change(sustained + transient, fields(),
                            {{sustained, fields()[0], 0.5 * held_n_per_mm2, 0.05 * held_n_per_mm2, slow_s}});
        change.begin(at(500ms), held, true);
        change.hear(0, at(500ms));
        return change.factor(1, [](std::uint32_t) { return CommonChange::Sustained{}; });
    };
    std::vector<double> below_it(sustained, 0.0);
    below_it[0] = held_n_per_mm2;
    const double w = std::exp(-1 / 0.72);
    const CommonChange::Factor told = fallen(below_it);
    const CommonChange::Factor expected =
        fallen(std::vector<double>(sustained, held_n_per_mm2 / (1 + 2 * w + w * w)));
    EXPECT_NEAR(told.mean, expected.mean, 1e-9);
    EXPECT_NEAR(told.sigma, expected.sigma, 1e-9);
    EXPECT_GT(std::abs(told.mean - fallen(std::vector<double>(sustained, held_n_per_mm2)).mean), 0.01);
}

// A rise by an eighth of the part makes the same transient afferents fire.
TEST(CommonChange, LowersNoPressureThatRises) {
    CommonChange change = under_contact();
    fall_by(change, 0.5);
    const auto rises = [](std::uint32_t i) {
        return i < 3 ? CommonChange::Sustained{.rises = true} : silent(i);
    };
    EXPECT_GT(change.factor(1, rises).mean, 0.95);
    const auto measured = [](std::uint32_t i) {
        return i < 3 ? CommonChange::Sustained{.held = held_n_per_mm2, .measured = 1.05 * held_n_per_mm2}
                     : silent(i);
    };
    EXPECT_GT(change.factor(1, measured).mean, 0.95);
    const auto not_held = [](std::uint32_t i) {
        return i < 3 ? CommonChange::Sustained{.measured = held_n_per_mm2} : silent(i);
    };
    const auto unknown = [](std::uint32_t i) { return i < 3 ? CommonChange::Sustained{} : silent(i); };
    EXPECT_EQ(change.factor(1, not_held), change.factor(1, unknown)) << "no change without a pressure before";
}

// Where a slightly higher pressure would have made sustained afferents fire, their silence rules out a rise.
TEST(CommonChange, TellsAFallFromARiseBySilence) {
    CommonChange change = under_contact();
    fall_by(change, 0.5);
    EXPECT_LT(factor(change).mean, factor(change, 1, 2).mean - 0.1);
}

TEST(CommonChange, KnowsLessOfWhatWasLost) {
    CommonChange change = under_contact();
    fall_by(change, 0.5);
    EXPECT_GT(factor(change, 0.7).sigma, 1.1 * factor(change).sigma);
}

// Afferents that have never fired may be dead: of these the silence does not count.
TEST(CommonChange, LeavesOutAfferentsThatNeverFire) {
    CommonChange fresh(sustained + transient, fields(), transients());
    fall_by(fresh, 0.5);
    CommonChange known = under_contact();
    fall_by(known, 0.5);
    EXPECT_GT(factor(fresh).sigma, factor(known).sigma);
    EXPECT_LT(std::abs(factor(fresh).mean - 0.5), 2 * factor(fresh).sigma);
}

TEST(CommonChange, ContainsAGainThatIsToldWrong) {
    for (const double told_gain : {0.8, 1.25}) {
        CommonChange change = under_contact(transients(told_gain));
        fall_by(change, 0.5);
        const auto [mean, sigma] = factor(change);
        EXPECT_LT(std::abs(mean - 0.5), 2 * sigma) << told_gain;
    }
}

// Where the change takes long against tau_m, the membrane leaks, and the same spikes tell of a larger fall.
TEST(CommonChange, TakesLeakingMembranesIntoAccount) {
    CommonChange slow = under_contact();
    CommonChange quick = under_contact(transients(1, 0.01));
    fall_by(slow, 0.5);
    fall_by(quick, 0.5);
    EXPECT_LT(factor(quick).mean, factor(slow).mean - 0.1);
}

TEST(CommonChange, GoesOnFromASnapshot) {
    CommonChange one = under_contact();
    fall_by(one, 0.5);
    CommonChange other(sustained + transient, fields(), transients());
    other.resume(one.snapshot());
    EXPECT_EQ(factor(other), factor(one));
    EXPECT_EQ(other.ended(), one.ended());
    other.restart();
    EXPECT_FALSE(other.happened());
    EXPECT_THROW(other.resume(CommonChange(sustained, fields(), {}).snapshot()), ParameterError);
}

TEST(CommonChange, RefusesAfferentsThatCannotBe) {
    const auto made = [](CommonChange::Transient one) {
        return CommonChange(sustained + transient, fields(), {one});
    };
    const CommonChange::Transient good = transients()[0];
    EXPECT_NO_THROW((void)made(good));
    CommonChange::Transient bad = good;
    bad.address = sustained + transient;
    EXPECT_THROW((void)made(bad), ParameterError);
    for (double CommonChange::Transient::*const field :
         {&CommonChange::Transient::fall_n_per_mm2, &CommonChange::Transient::rise_n_per_mm2,
          &CommonChange::Transient::tau_m_s})
        for (const double value : {0.0, std::nan("")}) {
            bad = good;
            bad.*field = value;
            EXPECT_THROW((void)made(bad), ParameterError);
        }
    EXPECT_THROW((void)CommonChange(sustained + transient, {}, {good}), ParameterError);
}

}  // namespace
}  // namespace afferent
