#include "afferent/decoders/force_rate_curves.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "afferent/decoders/grip_estimator.hpp"
#include "afferent/neurons/rate.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "tests/decoders/afferents.hpp"

namespace afferent {
namespace {

// Interpolation is good to 5e-5 of the curvature; a few times that where the curve is steep.
constexpr double interpolation = 1e-3;

// The first interval of a neuron that feels the force is that of the onset's rate, and once it has adapted
// they are those of the steady rate.
TEST(DecodedAfferents, HaveTheRatesAtWhichTheirNeuronsFire) {
    for (const double felt_n : {0.5, 3.0, 10.0}) {
        const auto group = group_with(2);
        const auto spikes = fired(group, 5s, [&](double) { return felt_n; });
        ASSERT_GT(spikes.size(), 3U);
        EXPECT_NEAR(1 / group.rate_hz(RateKind::onset, felt_n), seconds(spikes[1].time - spikes[0].time),
                    1e-8);
        for (const RateKind kind : {RateKind::onset, RateKind::steady})
            EXPECT_NEAR(group.grip_n(kind, group.rate_hz(kind, felt_n)), felt_n, 1e-6);
        const std::size_t last = spikes.size() - 1;
        EXPECT_NEAR(1 / group.rate_hz(RateKind::steady, felt_n),
                    seconds(spikes[last].time - spikes[last - 1].time), 1e-7);
    }
}

TEST(ForceRateCurve, RefusesPointsThatDoNotRise) {
    const auto refused = [](std::vector<ForceRateCurve::Point> points) {
        try {
            ForceRateCurve curve(std::move(points));
        } catch (const ParameterError& error) {
            return error.field();
        }
        return std::string();
    };
    EXPECT_EQ(refused({{0, 0}, {1, 5}}), "");
    EXPECT_EQ(refused({{0, 0}}), "curve");
    EXPECT_EQ(refused({{-1e-9, 0}, {1, 5}}), "curve.force_n");
    EXPECT_EQ(refused({{1, 0}, {1, 5}}), "curve.force_n");
    EXPECT_EQ(refused({{0, -1e-9}, {1, 5}}), "curve.rate_hz");
    EXPECT_EQ(refused({{0, 5}, {1, 5}}), "curve.rate_hz");
    EXPECT_EQ(refused({{0, 0}, {std::numeric_limits<double>::quiet_NaN(), 5}}), "curve.force_n");
}

TEST(ForceRateCurves, OfAGroupFollowItsRates) {
    for (const RateKind kind : {RateKind::steady, RateKind::onset}) {
        const auto group = group_with(2);
        const ForceRateCurve curve = group_curve(group, kind, 20);
        EXPECT_NEAR(curve.points().front().force_n, 0.3, 1e-15);
        EXPECT_EQ(curve.points().front().rate_hz, 0);
        for (const double force_n : {0.5, 1.0, 3.0, 10.0, 19.9})
            EXPECT_NEAR(curve.rate_hz(force_n), group.rate_hz(kind, force_n),
                        interpolation * group.rate_hz(kind, force_n));
        EXPECT_EQ(curve.largest_n(), 20);
        EXPECT_EQ(curve.rate_hz(20), group.rate_hz(kind, 20));
    }
}

// On a chip an interval is a whole number of ticks, so that a rate has steps; the width of its integers makes
// others, of about a thousandth where a tick is short.
TEST(ForceRateCurves, OfAChipFollowItsRatesToATick) {
    for (const RateKind kind : {RateKind::steady, RateKind::onset})
        for (const std::uint32_t tick_us : {1U, 100U}) {
            FixedPointParameters chip;
            chip.tick_us = tick_us;
            const double drive_mv_per_n = 2 * rheobase_mv(LifParameters());
            const DecodedAfferents::Group group{chip, drive_mv_per_n, 0};
            const ForceRateCurve curve = group_curve(group, kind, 20);
            // The drive is the rheobase at 0.5 N; in a short tick it adds little to an integer.
            EXPECT_NEAR(curve.points().front().force_n, 0.5, tick_us == 1 ? 0.06 : 1e-3);
            for (const double force_n : {0.6, 1.0, 3.0, 10.0, 19.9}) {
                const double rate = group.rate_hz(kind, force_n);
                const double step = rate * rate * tick_us * 1e-6;
                constexpr double hardly_any_hz = 1e-5;  // where it is silent below a step
                EXPECT_NEAR(curve.rate_hz(force_n), rate, 2 * interpolation * rate + step + hardly_any_hz)
                    << tick_us << ' ' << force_n;
            }
        }
}

// What was computed for one neuron serves others only where it is the same for them.
TEST(ForceRateCurves, HaveEachNeuronsOwnForcesWhateverWasAskedForBefore) {
    const LifParameters usual;
    std::vector<LifParameters> neurons(8, usual);
    neurons[1].tau_m_ms = 12;
    neurons[2].tau_g_ms = 90;
    neurons[3].v_r_mv = -66;
    neurons[4].v_th_mv = -49;
    neurons[5].e_k_mv = -75;
    neurons[6].delta_g = 0.07;
    neurons[7].refractory_ms = 1;
    for (int pass = 0; pass < 2; ++pass)
        for (const RateKind kind : {RateKind::steady, RateKind::onset})
            for (const LifParameters& neuron : neurons) {
                const DecodedAfferents::Group group{neuron, 20, 0};
                const ForceRateCurve curve = group_curve(group, kind, 20);
                ASSERT_GT(curve.points().size(), 100U);
                for (std::size_t i = 1; i + 1 < curve.points().size(); ++i)
                    ASSERT_EQ(curve.points()[i].force_n, group.grip_n(kind, curve.points()[i].rate_hz))
                        << neuron.describe();
            }
}

TEST(ForceRateCurves, BeginAtTheRateOfTheBiasWhereItExceedsTheRheobase) {
    const LifParameters neuron;
    const DecodedAfferents::Group group{neuron, 2, neuron.rheobase_mv() + 1};
    const ForceRateCurve curve = group_curve(group, RateKind::steady, 20);
    EXPECT_LT(group.threshold_n(), 0);
    EXPECT_EQ(curve.points().front().force_n, 0);
    EXPECT_EQ(curve.points().front().rate_hz, rate_hz(RateKind::steady, neuron, neuron.rheobase_mv() + 1));
}

TEST(ForceRateCurves, OfAfferentsAlikeAreMultiplesOfOne) {
    DecodedAfferents afferents{.addresses = 3, .largest_grip_n = 20};
    for (Address address = 0; address < 3; ++address) afferents.add(address, group_with(2), 1.0 / 3);
    const ForceRateCurve pooled = pooled_curve(afferents, RateKind::steady);
    const ForceRateCurve one = group_curve(group_with(2), RateKind::steady, 20);
    ASSERT_EQ(pooled.points().size(), one.points().size());
    for (std::size_t i = 0; i < one.points().size(); ++i) {
        EXPECT_EQ(pooled.points()[i].force_n, one.points()[i].force_n);
        EXPECT_EQ(pooled.points()[i].rate_hz, one.points()[i].rate_hz * 3);
    }
}

TEST(ForceRateCurves, OfAfferentsUnlikeAreTheSumOfAllThatHaveAShare) {
    const ForceRateCurve pooled = pooled_curve(fingertips(), RateKind::steady);
    EXPECT_LE(pooled.points().size(), 512U);
    for (const double force_n : {0.5, 1.0, 3.0, 10.0, 19.9}) {
        const double sum_hz = 2 * group_with(2).rate_hz(RateKind::steady, force_n) +
                              group_with(4).rate_hz(RateKind::steady, force_n);
        EXPECT_NEAR(pooled.rate_hz(force_n), sum_hz, interpolation * sum_hz);
    }
}

// No rate is searched for at each force of the sum: a search takes some fifty times as long as a point.
TEST(ForceRateCurves, OfAfferentsUnlikeAddUpTheirOwn) {
    const ForceRateCurve pooled = pooled_curve(fingertips(), RateKind::steady);
    const ForceRateCurve thumb = group_curve(group_with(2), RateKind::steady, 20);
    const ForceRateCurve index = group_curve(group_with(4), RateKind::steady, 20);
    for (const auto& [force_n, rate_hz] : pooled.points())
        EXPECT_EQ(rate_hz, 2 * thumb.rate_hz(force_n) + index.rate_hz(force_n)) << force_n;
}

// Each afferent has a gain of its own; a sample of them stands for all. Its mean is off by no more than four
// standard errors.
TEST(ForceRateCurves, OfThousandsUnlikeAreTheSumOfAll) {
    constexpr std::uint32_t count = 5000;
    DecodedAfferents afferents{.addresses = count, .largest_grip_n = 20};
    std::mt19937 random(1);
    std::uniform_real_distribution<double> gain(2, 4);
    std::vector<DecodedAfferents::Group> groups;
    for (Address address = 0; address < count; ++address) {
        groups.push_back(group_with(gain(random)));
        afferents.add(address, groups.back(), 1.0 / count);
    }
    const ForceRateCurve pooled = pooled_curve(afferents, RateKind::steady);
    for (const double force_n : {3.0, 19.0}) {
        double sum = 0;
        double squares = 0;
        for (const auto& group : groups) {
            const double rate_hz = group.rate_hz(RateKind::steady, force_n);
            sum += rate_hz;
            squares += rate_hz * rate_hz;
        }
        const double sd = std::sqrt(squares / count - (sum / count) * (sum / count));
        EXPECT_NEAR(pooled.rate_hz(force_n), sum, count * 4 * sd / std::sqrt(1024) + interpolation * sum);
        EXPECT_GT(sd, 0.05 * sum / count) << "too much alike to tell";
    }
}

// Every one of them counts, those that are not among the sample as well.
TEST(ForceRateCurves, OfThousandsNearlyAlikeAreMultiplesOfOne) {
    constexpr std::uint32_t count = 2500;
    DecodedAfferents afferents{.addresses = count, .largest_grip_n = 20};
    for (Address address = 0; address < count; ++address)
        afferents.add(address, group_with(3 * (1 + 1e-9 * address)), 1.0 / count);
    ASSERT_EQ(afferents.groups.size(), count);
    const double one_hz = group_with(3).rate_hz(RateKind::steady, 10);
    EXPECT_NEAR(pooled_curve(afferents, RateKind::steady).rate_hz(10) / (count * one_hz), 1, 2e-4);
}

TEST(ForceRateCurves, RefuseAfferentsThatTellNothing) {
    EXPECT_THROW(pooled_curve({}, RateKind::steady), ParameterError);
    DecodedAfferents shareless{.addresses = 1, .largest_grip_n = 20};
    shareless.add(0, group_with(0), 0);
    EXPECT_THROW(pooled_curve(shareless, RateKind::steady), ParameterError);
    EXPECT_THROW(group_curve(group_with(2), RateKind::steady, 0.3), ParameterError)
        << "silent over the whole range";
}

// A converter of 12 bits whose noise is some tens of counts reaches 98 of 100; loading reads low by the
// hysteresis.
TEST(DecodedAfferents, AreAtFullScaleFromAFiftiethBelowItOn) {
    DecodedAfferents decoded = fingertips();
    EXPECT_DOUBLE_EQ(full_scale_fraction(decoded), 0.98);
    decoded.hysteresis = 0.1;
    EXPECT_DOUBLE_EQ(full_scale_fraction(decoded), 0.882);
}

TEST(DecodedAfferents, KeepOneGroupOfAfferentsAlike) {
    const DecodedAfferents afferents = fingertips();
    ASSERT_EQ(afferents.groups.size(), 3U);
    EXPECT_EQ(afferents.afferents[1].group, afferents.afferents[0].group);
    EXPECT_EQ(afferents.afferents[2].group, 1U);
    EXPECT_EQ(afferents.read(), (std::vector<bool>{true, true, false, true, true}));
    EXPECT_NO_THROW(afferents.check());
}

TEST(GripEstimator, NamesTheShareWhereNobodyHasOne) {
    DecodedAfferents afferents = fingertips();
    for (auto& afferent : afferents.afferents) afferent.share = 0;
    try {
        GripEstimator::of(afferents, RateKind::steady, Pooling::per_neuron);
        ADD_FAILURE() << "accepted";
    } catch (const ParameterError& error) {
        EXPECT_EQ(error.field(), "share");
    }
}

TEST(DecodedAfferents, AreRefusedWithTheFieldThatIsWrong) {
    const auto refused = [](auto&& change) -> std::string {
        DecodedAfferents afferents = fingertips();
        change(afferents);
        try {
            afferents.check();
        } catch (const ParameterError& error) {
            return error.field();
        }
        return "nothing";
    };
    EXPECT_EQ(refused([](auto& a) { a.addresses = 4; }), "address");
    EXPECT_EQ(refused([](auto& a) { a.afferents[1].address = 0; }), "address");
    EXPECT_EQ(refused([](auto& a) { a.afferents[0].group = 3; }), "group");
    EXPECT_EQ(refused([](auto& a) { a.afferents[0].share = -0.1; }), "share");
    EXPECT_EQ(refused([](auto& a) { a.afferents[0].share = std::nan(""); }), "share");
    EXPECT_EQ(refused([](auto& a) { a.groups[0].drive_mv_per_n = HUGE_VAL; }), "drive_mv_per_n");
    EXPECT_EQ(refused([](auto& a) { a.groups[0].bias_mv = std::nan(""); }), "bias_mv");
    EXPECT_EQ(refused([](auto& a) { a.largest_grip_n = -1; }), "largest_grip_n");
    EXPECT_EQ(refused([](auto& a) { a.hysteresis = -0.1; }), "hysteresis");
    EXPECT_EQ(refused([](auto& a) { a.hysteresis = 1; }), "hysteresis");
    EXPECT_EQ(refused([](auto& a) { a.hysteresis = 0.99; }), "nothing");
    for (const auto& [name, member] : {std::pair("uncertainty.gain", &Uncertainty::gain),
                                       std::pair("uncertainty.common_gain", &Uncertainty::common_gain),
                                       std::pair("uncertainty.share", &Uncertainty::share),
                                       std::pair("uncertainty.share_time_s", &Uncertainty::share_time_s),
                                       std::pair("uncertainty.offset_n", &Uncertainty::offset_n),
                                       std::pair("uncertainty.hysteresis", &Uncertainty::hysteresis),
                                       std::pair("uncertainty.adaptation", &Uncertainty::adaptation)}) {
        EXPECT_EQ(refused([of = member](auto& a) { a.uncertainty.*of = -0.1; }), name);
        const bool may_be_0 = member != &Uncertainty::share_time_s;
        EXPECT_EQ(refused([of = member](auto& a) { a.uncertainty.*of = 0; }), may_be_0 ? "nothing" : name);
    }
}

}  // namespace
}  // namespace afferent
