#include "afferent/decoders/emg_gain.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr EmgGain::Parameters defaults{.onset_n = 2, .lambda_n = 3, .limit_n = 10};

EmgGain::Parameters continuous() {
    EmgGain::Parameters parameters = defaults;
    parameters.shape = EmgGain::Shape::continuous;
    return parameters;
}

TEST(EmgGain, HasTheDefaultsOfAScene) {
    EXPECT_EQ(EmgGain::Parameters(), (EmgGain::Parameters{.onset_n = 2,
                                                          .lambda_n = 3,
                                                          .limit_n = 10,
                                                          .shape = EmgGain::Shape::exponential,
                                                          .upper_bound_sigmas = 0,
                                                          .doubtful = EmgGain::Doubtful::by_upper_bound,
                                                          .saturated = 0}));
}

TEST(EmgGain, IsOneBelowOnsetDecaysAndIsZeroFromTheLimit) {
    const EmgGain gain(defaults);
    EXPECT_EQ(gain(0), 1);
    EXPECT_EQ(gain(2), 1);
    EXPECT_DOUBLE_EQ(gain(5), std::exp(-1.0));
    EXPECT_DOUBLE_EQ(gain(std::nextafter(10, 0)), std::exp(-8.0 / 3));
    EXPECT_EQ(gain(10), 0);
    EXPECT_EQ(gain(1e9), 0);
}

TEST(EmgGain, ReachesZeroWithoutAStepWhereAsked) {
    const EmgGain gain(continuous());
    EXPECT_EQ(gain(2), 1);
    const double at_limit = std::exp(-8.0 / 3);
    EXPECT_DOUBLE_EQ(gain(5), (std::exp(-1.0) - at_limit) / (1 - at_limit));
    // Its slope is at most 1/lambda over 1 − e^(−8/3), so within 1e-9 N of the limit it is below 1e-9.
    EXPECT_LT(gain(10 - 1e-9), 1e-9);
    EXPECT_EQ(gain(10), 0);
}

TEST(EmgGain, NeverRisesWithForceAndStaysWithinZeroAndOne) {
    for (const auto& parameters : {defaults, continuous()}) {
        const EmgGain gain(parameters);
        double before = 1;
        for (double force = 0; force < 12; force += 0.01) {
            EXPECT_GE(gain(force), 0);
            EXPECT_LE(gain(force), before);
            before = gain(force);
        }
    }
}

TEST(EmgGain, DoesNotCloseOnWhatIsNotANumber) {
    EXPECT_EQ(EmgGain(defaults)(std::numeric_limits<double>::quiet_NaN()), 0);
    EXPECT_EQ(EmgGain(defaults)(std::numeric_limits<double>::infinity()), 0);
}

TEST(EmgGain, RefusesALimitAtTheOnset) {
    const auto refusal = [](const EmgGain::Parameters& parameters) -> std::string {
        try {
            EmgGain{parameters};
        } catch (const ParameterError& error) {
            return error.what();
        }
        return "accepted";
    };
    EXPECT_EQ(refusal({.onset_n = 2, .limit_n = 2}), "limit_n must be > onset_n, is 2");
    EXPECT_EQ(refusal({.onset_n = -1}), "onset_n must be >= 0, is -1");
    EXPECT_EQ(refusal({.lambda_n = 0}), "lambda_n must be > 0, is 0");
    EXPECT_EQ(refusal({.upper_bound_sigmas = -1}), "upper_bound_sigmas must be >= 0, is -1");
    EXPECT_EQ(refusal({.saturated = 1.5}), "saturated must be 0 to 1, is 1.5");
    EXPECT_EQ(refusal({.onset_n = 0, .lambda_n = 0.5, .limit_n = 0.1}), "accepted");
}

TEST(EmgGain, IsThatOfTheUpperBoundWhereAsked) {
    EmgGain::Parameters parameters = defaults;
    const EmgGain mean(parameters);
    parameters.upper_bound_sigmas = 2;
    const EmgGain bound(parameters);
    EXPECT_DOUBLE_EQ(bound({4, 0.5, 50}), std::exp(-(4 + 2 * 0.5 - 2) / 3.0));
    EXPECT_DOUBLE_EQ(bound({4, 0, 50}), std::exp(-(4 - 2) / 3.0));
    EXPECT_DOUBLE_EQ(mean({4, 0.5, 50}), std::exp(-(4 - 2) / 3.0));
    EXPECT_EQ(bound({9, 0.5, 50}), 0) << "the bound is at the limit";
}

TEST(EmgGain, IsNoHigherThanThatOfTheForceThatComes) {
    EmgGain::Parameters parameters = defaults;
    const auto rising = [](double now_n, double coming_n) {
        return Estimate{.force_n = now_n, .sigma_n = 0.1, .coming = ExpectedForce{coming_n, 0.5}};
    };
    EXPECT_DOUBLE_EQ(EmgGain(parameters)(rising(3, 6)), std::exp(-(6 - 2) / 3.0));
    EXPECT_DOUBLE_EQ(EmgGain(parameters)(rising(3, 1)), std::exp(-(3 - 2) / 3.0));
    EXPECT_EQ(EmgGain(parameters)(rising(1, 12)), 0);
    EXPECT_EQ(EmgGain(parameters)(rising(1, std::numeric_limits<double>::quiet_NaN())), 0);
    parameters.upper_bound_sigmas = 2;
    EXPECT_DOUBLE_EQ(EmgGain(parameters)(rising(3, 6)), std::exp(-(6 + 2 * 0.5 - 2) / 3.0));
    Estimate saturated = rising(3, 3);
    saturated.doubt = Doubt::saturated;
    EXPECT_EQ(EmgGain(parameters)(saturated), 0);
    parameters.upper_bound_sigmas = 0;
    Estimate slow = rising(3, 4);
    slow.doubt = Doubt::slow;
    EXPECT_DOUBLE_EQ(EmgGain(parameters)(slow), std::exp(-(4 + 2 * 0.5 - 2) / 3.0)) << "doubt takes two";
}

Estimate doubtful(Doubt doubt, double force_n, double sigma_n) {
    return {.force_n = force_n, .sigma_n = sigma_n, .rate_hz = 50, .doubt = doubt};
}

TEST(EmgGain, OfADoubtfulEstimateIsThatOfItsUpperBound) {
    EmgGain::Parameters parameters = defaults;
    const EmgGain gain(parameters);
    for (const Doubt doubt : {Doubt::slow, Doubt::unheard, Doubt::contradicted, Doubt::unknown}) {
        EXPECT_DOUBLE_EQ(gain(doubtful(doubt, 3, 1)), std::exp(-(3 + 2 * 1 - 2) / 3.0));
        EXPECT_EQ(gain(doubtful(doubt, 3, 3.5)), 0) << "the bound is at the limit";
        EXPECT_EQ(gain(doubtful(doubt, 1, 0.5)), 1) << "the bound is at the onset";
        for (const double sigma_n : {std::numeric_limits<double>::quiet_NaN(), -1.0})
            EXPECT_EQ(gain(doubtful(doubt, 0, sigma_n)), 0);
    }
    EXPECT_DOUBLE_EQ(gain(doubtful(Doubt::none, 3, 1)), std::exp(-(3 - 2) / 3.0));
    // As many sigmas as the scene says, if that is more than two.
    parameters.upper_bound_sigmas = 1;
    EXPECT_DOUBLE_EQ(EmgGain(parameters)(doubtful(Doubt::slow, 3, 1)), std::exp(-(3 + 2 * 1 - 2) / 3.0));
    parameters.upper_bound_sigmas = 4;
    EXPECT_DOUBLE_EQ(EmgGain(parameters)(doubtful(Doubt::slow, 3, 1)), std::exp(-(3 + 4 * 1 - 2) / 3.0));
}

TEST(EmgGain, OfASaturatedEstimateIsWhatTheSceneNamesAndNoMoreThanThatOfTheForce) {
    EmgGain::Parameters parameters = defaults;
    EXPECT_EQ(EmgGain(parameters)(doubtful(Doubt::saturated, 1, 0)), 0);
    parameters.saturated = 0.25;
    const EmgGain gain(parameters);
    EXPECT_EQ(gain(doubtful(Doubt::saturated, 1, 0)), 0.25);
    EXPECT_DOUBLE_EQ(gain(doubtful(Doubt::saturated, 8, 0)), std::exp(-(8 - 2) / 3.0));
    EXPECT_EQ(gain(doubtful(Doubt::saturated, 10, 0)), 0);
    EXPECT_EQ(gain(doubtful(Doubt::saturated, std::numeric_limits<double>::quiet_NaN(), 0)), 0);
    parameters.saturated = 1;
    EXPECT_EQ(EmgGain(parameters)(doubtful(Doubt::saturated, 1, 0)), 1);
    for (const double wrong : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()}) {
        parameters.saturated = wrong;
        EXPECT_THROW(EmgGain{parameters}, ParameterError);
    }
}

TEST(EmgGain, IgnoresADoubtWhereAskedAsThePaperDoes) {
    EmgGain::Parameters parameters = defaults;
    parameters.doubtful = EmgGain::Doubtful::as_estimated;
    const EmgGain gain(parameters);
    for (const Doubt doubt : {Doubt::none, Doubt::slow, Doubt::unknown, Doubt::saturated})
        EXPECT_DOUBLE_EQ(gain(doubtful(doubt, 3, 100)), std::exp(-(3 - 2) / 3.0));
}

TEST(EmgGain, DoesNotCloseOnADoubtThatIsNotANumber) {
    EmgGain::Parameters parameters = defaults;
    parameters.upper_bound_sigmas = 1;
    for (const double sigma_n :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1.0})
        EXPECT_EQ(EmgGain(parameters)({0, sigma_n, 50}), 0) << sigma_n;
    EXPECT_EQ(EmgGain(defaults)({0, std::numeric_limits<double>::quiet_NaN(), 50}), 1)
        << "the estimate alone counts";
    parameters.upper_bound_sigmas = -1;
    EXPECT_THROW(EmgGain{parameters}, ParameterError);
}

}  // namespace
}  // namespace afferent
