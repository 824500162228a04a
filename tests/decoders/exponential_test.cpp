#include "afferent/decoders/exponential.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "afferent/runtime/parameter_error.hpp"
#include "tests/decoders/afferents.hpp"

namespace afferent {
namespace {

// Two afferents and a third that is twice as steep: how often they fire in sum where each feels that force.
double pooled_hz(double force_n) {
    return 2 * group_with(2).rate_hz(RateKind::steady, force_n) +
           group_with(4).rate_hz(RateKind::steady, force_n);
}

// The force at which they do, by bisection.
double pooled_n(double rate_hz) {
    double low_n = 0.3;
    double high_n = 20;
    while (high_n - low_n > 1e-9) {
        const double middle_n = (low_n + high_n) / 2;
        (pooled_hz(middle_n) < rate_hz ? low_n : high_n) = middle_n;
    }
    return low_n;
}

TEST(Exponential, InvertsThePooledCurve) {
    const DecodedAfferents afferents = fingertips();
    Exponential decoder({.time_constant = 40ms}, afferents);
    const auto train = regular_train(0, 5ms, 10ms, 1s);
    decoder.observe(at(0s), at(1s), train);
    const Estimate estimate = decoder.estimate(at(1s));

    // The last spike is 5 ms old, and 100 came before it: a geometric sum.
    const double rate_hz = std::exp(-5.0 / 40) / -std::expm1(-10.0 / 40) / 0.040;
    EXPECT_NEAR(estimate.rate_hz, rate_hz / 4, 1e-9) << "the fourth afferent feels nothing, but is read";
    // The curve is interpolated.
    EXPECT_NEAR(pooled_hz(estimate.force_n), rate_hz, 1e-3 * rate_hz);
    // The first two of the four are alike, and count as one that is twice as fast.
    const double sigma_hz = std::sqrt((4 + 1 + 1) / 12.0) / 0.040;
    const double low_n = pooled_n(rate_hz - sigma_hz);
    const double high_n = pooled_n(rate_hz + sigma_hz);
    EXPECT_NEAR(estimate.sigma_n, (high_n - low_n) / 2, 1e-3 * high_n);
}

TEST(Exponential, WeighsNeuronsByTheirShareWhereEachIsInvertedByItself) {
    Exponential decoder({.pooling = Pooling::per_neuron}, fingertips());
    decoder.observe(at(0s), at(1s), regular_train(3, 5ms, 10ms, 1s));
    const double rate_hz = std::exp(-5.0 / 40) / -std::expm1(-10.0 / 40) / 0.040;
    // Its share is a half.
    const double force_n = 2 * decoder.estimate(at(1s)).force_n;
    EXPECT_NEAR(group_with(4).rate_hz(RateKind::steady, force_n), rate_hz, 1e-3 * rate_hz);
}

TEST(Exponential, IsLessCertainTheLessIsKnown) {
    Exponential decoder({}, fingertips());
    decoder.observe(at(0s), at(1s), regular_train(3, 5ms, 10ms, 1s));
    double before = decoder.estimate(at(1s)).sigma_n;
    for (const Duration later : {10ms, 30ms, 60ms}) {
        const double sigma_n = decoder.estimate(at(1s + later)).sigma_n;
        EXPECT_GT(sigma_n, before);
        before = sigma_n;
    }
}

TEST(Exponential, NeverNeedsMoreMemoryHoweverBusy) {
    Exponential decoder({.pooling = Pooling::per_neuron}, fingertips());
    const std::size_t bytes = decoder.bytes();
    decoder.observe(at(0s), at(1s), regular_train(0, 0ns, 10us, 1s));
    EXPECT_EQ(decoder.bytes(), bytes);
    EXPECT_EQ(decoder.estimate(at(1s)).force_n, 5) << "a quarter of the range: the others are silent";
}

// The train has long been regular. Its decayed sum is lowest just before the next spike.
TEST(Exponential, KnowsTheLowestRateThatItFindsInARegularTrain) {
    const ExponentialParameters parameters{.time_constant = 40ms};
    for (const double rate_hz : {5.0, 50.0, 500.0}) {
        double sum_hz = 0;
        for (int k = 1; k < 10'000; ++k) sum_hz += std::exp(-k / rate_hz / 0.04) / 0.04;
        EXPECT_NEAR(parameters.trough_hz(rate_hz), sum_hz, 1e-9 * sum_hz) << rate_hz;
    }
    EXPECT_EQ(parameters.trough_hz(0), 0);
    EXPECT_NEAR(parameters.window_s(), 0.04 * std::sqrt(2.0), 1e-12);
}

TEST(Exponential, RefusesATimeConstantOfZeroAndASnapshotOfAnotherPooling) {
    EXPECT_THROW(Exponential({.time_constant = 0ns}, fingertips()), ParameterError);
    Exponential pooled({}, fingertips());
    Exponential each({.pooling = Pooling::per_neuron}, fingertips());
    EXPECT_THROW(each.resume(pooled.snapshot()), ParameterError);
    EXPECT_THROW(pooled.resume(each.snapshot()), ParameterError);
}

}  // namespace
}  // namespace afferent
