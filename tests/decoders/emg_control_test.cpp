// Laws of the command, whatever it is given, and the command by its formula.
#include "afferent/decoders/emg_control.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double efforts[] = {-infinity, -1, -0.0, 0, 0.3, 1, 7, infinity, nan};
constexpr double forces_n[] = {-infinity, -1, 0, 1.9, 2, 5, 9.99, 10, 1e9, infinity, nan};
constexpr GripState states[] = {GripState::operating, GripState::frozen, GripState::safe};

constexpr double sigmas_n[] = {0, 1, infinity, nan};

// Calls with everything that it may be given, for each safe state, by the estimate and by its upper bound.
template <class Check>
void everywhere(const Check& check) {
    std::size_t calls = 0;
    for (const auto& control :
         {EmgControl({.gain = {}, .safe_state = SafeState::hold}),
          EmgControl({.gain = {.upper_bound_sigmas = 2}, .safe_state = SafeState::open})})
        for (const GripState state : states)
            for (const double force_n : forces_n)
                for (const double closing : efforts)
                    for (const double opening : efforts) {
                        const Estimate estimate{force_n, sigmas_n[calls++ % std::size(sigmas_n)], 50};
                        const Effort effort{closing, opening};
                        SCOPED_TRACE(testing::Message() << static_cast<int>(state) << ' ' << force_n << " N, "
                                                        << closing << ", " << opening);
                        check(control(estimate, state, effort), state, estimate, effort);
                    }
    EXPECT_EQ(calls, 2 * 3 * 11 * 81U);
}

TEST(EmgControl, GainAndCommandAreWithinTheirRanges) {
    everywhere([](const GripCommand& given, GripState, const Estimate&, const Effort&) {
        EXPECT_TRUE(given.gain >= 0 && given.gain <= 1) << given.gain;
        EXPECT_TRUE(given.command >= -1 && given.command <= 1) << given.command;
    });
}

TEST(EmgControl, NothingClosesUnlessOperating) {
    everywhere([](const GripCommand& given, GripState state, const Estimate&, const Effort&) {
        if (state == GripState::operating) return;
        EXPECT_EQ(given.gain, 0);
        EXPECT_LE(given.command, 0);
    });
}

TEST(EmgControl, WhatIsNotANumberNeverCloses) {
    everywhere([](const GripCommand& given, GripState, const Estimate& estimate, const Effort& effort) {
        const bool known =
            !std::isnan(estimate.force_n) && !std::isnan(effort.closing) && !std::isnan(effort.opening);
        EXPECT_TRUE(known || given.command <= 0);
    });
}

TEST(EmgControl, DoesNotCloseByABoundThatIsNotKnown) {
    const EmgControl control({.gain = {.upper_bound_sigmas = 2}, .safe_state = {}});
    EXPECT_EQ(control({0, nan, 50}, GripState::operating, {1, 0}).command, 0);
    EXPECT_EQ(control({0, 0.1, 50}, GripState::operating, {1, 0}).command, 1);
}

class EmgControls : public testing::Test {
  protected:
    const EmgControl hold{{.gain = {}, .safe_state = SafeState::hold}};
    const EmgControl open{{.gain = {}, .safe_state = SafeState::open}};
    static Estimate of(double force_n) { return {force_n, 1, 50}; }
};

// By default 1 up to 2 N, then e^(−(F − 2)/3), and 0 from 10 N on.
TEST_F(EmgControls, TurnDownTheClosingEffortAndNeverTheOpening) {
    for (const auto& [force_n, gain] : {std::pair{0.0, 1.0},
                                        {2.0, 1.0},
                                        {5.0, std::exp(-1.0)},
                                        {9.99, std::exp(-7.99 / 3)},
                                        {10.0, 0.0},
                                        {20.0, 0.0}})
        for (const Effort& effort : {Effort{0, 0}, {1, 0}, {0, 1}, {0.6, 0.2}, {1, 1}}) {
            const GripCommand given = hold(of(force_n), GripState::operating, effort);
            EXPECT_DOUBLE_EQ(given.gain, gain);
            EXPECT_DOUBLE_EQ(given.command, gain * effort.closing - effort.opening);
        }
}

TEST_F(EmgControls, ClampEffortsBeforeTheyCompensateEachOther) {
    EXPECT_EQ(hold(of(0), GripState::operating, {7, 0.25}).command, 0.75);
    EXPECT_EQ(hold(of(0), GripState::operating, {0.25, -3}).command, 0.25);
    EXPECT_EQ(hold(of(0), GripState::operating, {-5, 0}).command, 0);
    EXPECT_EQ(hold(of(20), GripState::operating, {infinity, 0}).command, 0)
        << "infinity times a gain of 0 is not a number";
}

TEST_F(EmgControls, DoNotCloseWhereAnEffortIsUnknownAndLetTheUserOpen) {
    EXPECT_EQ(hold(of(0), GripState::operating, {nan, 0.4}).command, -0.4);
    EXPECT_EQ(hold(of(0), GripState::operating, {0.4, nan}).command, 0);
    EXPECT_EQ(hold(of(0), GripState::operating, {nan, nan}).command, 0);
    EXPECT_EQ(hold(of(nan), GripState::operating, {1, 0.4}).command, -0.4);
}

TEST_F(EmgControls, LetTheUserOpenAndNotCloseWhereFrozenOrHolding) {
    for (const auto& control : {hold, open})
        EXPECT_EQ(control(of(0), GripState::frozen, {1, 0.3}), (GripCommand{0, -0.3}));
    EXPECT_EQ(hold(of(0), GripState::safe, {1, 0.3}), (GripCommand{0, -0.3}));
    EXPECT_EQ(hold(of(0), GripState::safe, {1, 0}), (GripCommand{0, 0}));
}

TEST_F(EmgControls, OpenByThemselvesWhereThatIsTheSafeState) {
    for (const double effort : efforts)
        EXPECT_EQ(open(of(0), GripState::safe, {effort, effort}), (GripCommand{0, -0.5}));
}

TEST(GripCommand, DoesNotMoveTheHandUnlessItIsGiven) { EXPECT_EQ(GripCommand(), (GripCommand{0, 0})); }

TEST(EmgControl, RefusesAGainThatIsNone) {
    EXPECT_THROW(EmgControl({.gain = {.lambda_n = 0}, .safe_state = {}}), ParameterError);
}

}  // namespace
}  // namespace afferent
