// Laws of every encoder of the list.
#include "afferent/encoders/encoders.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

TEST(Sustained, HasNoBiasUnlessItIsGiven) { EXPECT_EQ(Sustained::Parameters{.gain_mv_per_n = 1}.bias_mv, 0); }

template <class Variant>
struct TypesOf;
template <class... E>
struct TypesOf<std::variant<E...>> {
    using Types = testing::Types<E...>;
};

template <class E>
class EncoderLaws : public testing::Test {
  public:
    static EncoderParameters parameters(double gain, double bias_mv) {
        typename E::Parameters parameters{};
        if constexpr (requires { parameters.corner_hz; }) parameters.corner_hz = 50;
        if constexpr (requires { parameters.time; }) parameters.time = 20ms;
        if constexpr (requires { parameters.slow_time; }) {
            parameters.part = 1e-9;  // of which these laws tell nothing
            parameters.slow_time = 8s;
        }
        return parameters.with(gain, bias_mv);
    }
};
using Encoders = TypesOf<AnyEncoder>::Types;
TYPED_TEST_SUITE(EncoderLaws, Encoders);

TYPED_TEST(EncoderLaws, TellTheirGainAndBias) {
    const EncoderParameters parameters = this->parameters(2, -3);
    EXPECT_EQ(gain(parameters), 2);
    EXPECT_EQ(bias_mv(parameters), -3);
    EXPECT_EQ(gain(with_gain(parameters, 7, 1)), 7);
    EXPECT_EQ(bias_mv(with_gain(parameters, 7, 1)), 1);
    EXPECT_EQ(with_gain(parameters, 7, 1).index(), parameters.index());
    visit_encoder(parameters, []<class E>(const E&) { EXPECT_TRUE((std::is_same_v<E, TypeParam>)); });
}

TYPED_TEST(EncoderLaws, DriveByTheirBiasAloneOnUntouchedSkin) {
    visit_encoder(this->parameters(2, 5), []<Encoder E>(const E& encoder) {
        typename E::State state;
        for (int i = 0; i < 3; ++i)
            EXPECT_EQ(encoder.drive_mv(state, scene_start + std::chrono::milliseconds(i), 0), 5);
    });
}

// A force with a constant input of 3, and one of 6: in proportion to t⁰, t or t², long after its beginning.
TYPED_TEST(EncoderLaws, DriveInProportionToTheirInput) {
    const EncoderParameters parameters = this->parameters(2, 5);
    for (const double wanted : {3.0, 6.0}) {
        const auto force_n = [&](double t) {
            return input(parameters) == EncoderInput::force   ? wanted
                   : input(parameters) == EncoderInput::slope ? wanted * t
                                                              : wanted * t * t / 2;
        };
        visit_encoder(parameters, [&]<Encoder E>(const E& encoder) {
            typename E::State state;
            double drive_mv = 0;
            constexpr int steps = 2000;
            for (int i = 0; i <= steps; ++i)
                drive_mv = encoder.drive_mv(state, scene_start + i * Duration(100'000), force_n(i * 1e-4));
            // A parabola sampled at 10 kHz is bent 10,000 times a second, which the lags of 50 Hz leave
            // 2 / (1 + 200²)² of.
            EXPECT_NEAR(drive_mv, 5 + 2 * wanted, 1e-7);
        });
    }
}

// Forces within a range, as wild as they can be.
TYPED_TEST(EncoderLaws, StayBelowTheBoundOfTheirInput) {
    constexpr Duration sampling = 2ms;
    const EncoderParameters parameters = this->parameters(1, 0);
    const double bound = largest_input(parameters, 3, Interval(sampling));
    for (const int period : {1, 2, 4, 5, 7, 50}) {
        visit_encoder(parameters, [&]<Encoder E>(const E& encoder) {
            typename E::State state;
            for (int i = 0; i < 500; ++i)
                EXPECT_LE(encoder.drive_mv(state, scene_start + i * sampling, i / period % 2 * 3),
                          bound * (1 + 1e-12));
        });
    }
}

// A force that goes up and down with the sign of the response, reversed in time, reaches the bound of the
// second derivative.
TEST(Encoders, ReachTheBoundOfTheSecondDerivative) {
    constexpr double own_corner_hz = 5;
    const EncoderParameters parameters =
        Vibration::Parameters{.gain = 1, .bias_mv = 0, .corner_hz = own_corner_hz};
    const double per_s = 2 * std::numbers::pi * own_corner_hz;
    const double turns[]{3 - std::numbers::sqrt3, 3 + std::numbers::sqrt3};
    constexpr double end_s = 2;
    const auto force_n = [&](double time_s) {
        const double before_end = (end_s - time_s) * per_s;
        return before_end < turns[0] || before_end > turns[1] ? 3.0 : 0.0;
    };
    visit_encoder(parameters, [&]<Encoder E>(const E& encoder) {
        typename E::State state;
        double drive_mv = 0;
        for (int i = 0; i <= 20'000; ++i)
            drive_mv = encoder.drive_mv(state, scene_start + i * Duration(100'000), force_n(i * 1e-4));
        const double bound = largest_input(parameters, 3, Interval(0.1ms));
        EXPECT_NEAR(drive_mv, bound, 0.01 * bound);
    });
}

TEST(Encoders, BoundASuddenRiseWithinAFactorOfTwo) {
    const EncoderParameters parameters = DynamicSustained::Parameters{
        .gain_mv_per_n = 1, .bias_mv = 0, .time = Seconds(0.05), .corner_hz = 10};
    visit_encoder(parameters, [&]<Encoder E>(const E& encoder) {
        typename E::State state;
        double most_mv = encoder.drive_mv(state, scene_start, 0);
        for (int i = 1; i <= 2000; ++i)
            most_mv = std::max(most_mv, encoder.drive_mv(state, scene_start + i * Duration(10'000), 3));
        const double bound = largest_input(parameters, 3, Interval(0.01ms));
        EXPECT_GT(most_mv, 0.5 * bound);
        EXPECT_LE(most_mv, bound);
    });
}

TYPED_TEST(EncoderLaws, RefuseAGainThatIsNotPositiveAndWhatIsNotFinite) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    constexpr double infinity = std::numeric_limits<double>::infinity();
    EXPECT_NO_THROW(check(this->parameters(1e-9, 0)));
    for (const double bad : {0.0, -1.0, nan, infinity}) {
        EXPECT_THROW(check(this->parameters(bad, 0)), ParameterError);
        EXPECT_THROW(make_encoder(this->parameters(bad, 0)), ParameterError);
    }
    EXPECT_THROW(check(this->parameters(1, nan)), ParameterError);
    EXPECT_THROW(check(this->parameters(1, -infinity)), ParameterError);
}

// Encoders that rectify, with a negative half-wave and a threshold of their own.
template <class E>
class RectifyingEncoder : public testing::Test {
  public:
    static E encoder(const Rectification& rectification) {
        typename E::Parameters parameters = {};
        if constexpr (requires { parameters.corner_hz; }) parameters.corner_hz = 50;
        parameters.rectification = rectification;
        return E(parameters.with(1, 0));
    }
};
using RectifyingEncoders = testing::Types<Transient, BandTransient, Vibration>;
TYPED_TEST_SUITE(RectifyingEncoder, RectifyingEncoders);

// A force that rises and falls unevenly drives one encoder, and its mirror image another: where the first
// rectifies the positive half-wave, the second rectifies the negative one, weighed by negative_ratio.
TYPED_TEST(RectifyingEncoder, WeighsTheNegativeHalfWaveAndTakesTheThresholdOff) {
    constexpr double ratio = 0.25;
    const TypeParam whole = this->encoder({});
    const TypeParam part = this->encoder({.negative_ratio = ratio});
    typename TypeParam::State whole_state, part_state, mirrored_state;
    double largest = 0;
    int positive = 0;
    int negative = 0;
    std::vector<double> forces_n{0};
    for (int i = 1; i < 400; ++i)
        forces_n.push_back(std::sin(0.1 * i) + std::sin(0.37 * i) + (i % 7 == 0 ? 0.3 : 0));
    std::vector<double> sizes;
    for (std::size_t i = 0; i < forces_n.size(); ++i) {
        const TimePoint time = scene_start + static_cast<int>(i) * 1ms;
        const double size = whole.drive_mv(whole_state, time, forces_n[i]);
        const double drive = part.drive_mv(part_state, time, forces_n[i]);
        const double mirrored = part.drive_mv(mirrored_state, time, -forces_n[i]);
        EXPECT_EQ(std::max(drive, mirrored), size);
        EXPECT_EQ(std::min(drive, mirrored), ratio * size);
        (drive < mirrored ? negative : positive) += size > 0;
        largest = std::max(largest, size);
        sizes.push_back(size);
    }
    EXPECT_GT(positive, 100);
    EXPECT_GT(negative, 100);

    const double threshold = largest / 3;
    const TypeParam above = this->encoder({.threshold = threshold});
    typename TypeParam::State state;
    for (std::size_t i = 0; i < forces_n.size(); ++i)
        // Rounding: a threshold is taken off before or after a division.
        EXPECT_NEAR(above.drive_mv(state, scene_start + static_cast<int>(i) * 1ms, forces_n[i]),
                    std::max(0.0, sizes[i] - threshold), 1e-12 * largest);
}

TYPED_TEST(RectifyingEncoder, IsInvertedByNoDecoderUnlessItRectifiesAll) {
    typename TypeParam::Parameters parameters = {};
    if constexpr (requires { parameters.corner_hz; }) parameters.corner_hz = 50;
    for (const Rectification& rectification :
         {Rectification{.negative_ratio = 0}, Rectification{.negative_ratio = 0.9},
          Rectification{.threshold = 0.1}}) {
        parameters.rectification = rectification;
        EXPECT_FALSE(is_decodable(parameters.with(1, 0)));
    }
    parameters.rectification = {};
    EXPECT_EQ(is_decodable(parameters.with(1, 0)), (std::is_same_v<TypeParam, Transient>));
}

TYPED_TEST(RectifyingEncoder, HasALowerBoundByItsThreshold) {
    typename TypeParam::Parameters parameters = {};
    if constexpr (requires { parameters.corner_hz; }) parameters.corner_hz = 50;
    const double bound = largest_input(parameters.with(1, 0), 3, Interval(2ms));
    parameters.rectification.threshold = bound / 4;
    EXPECT_DOUBLE_EQ(largest_input(parameters.with(1, 0), 3, Interval(2ms)), bound * 3 / 4);
    parameters.rectification.threshold = 2 * bound;
    EXPECT_EQ(largest_input(parameters.with(1, 0), 3, Interval(2ms)), 0);
}

TYPED_TEST(RectifyingEncoder, RefusesARatioOutsideZeroToOneAndANegativeThreshold) {
    EXPECT_NO_THROW(this->encoder({.negative_ratio = 0, .threshold = 0}));
    EXPECT_NO_THROW(this->encoder({.negative_ratio = 1, .threshold = 1e9}));
    for (const double bad : {-0.01, 1.01, std::numeric_limits<double>::quiet_NaN()})
        EXPECT_THROW(this->encoder({.negative_ratio = bad}), ParameterError);
    for (const double bad : {-1e-9, std::numeric_limits<double>::infinity()})
        EXPECT_THROW(this->encoder({.threshold = bad}), ParameterError);
}

TEST(Encoders, AreTunableWhereTheGainIsAllThatIsBetweenForceAndDrive) {
    EXPECT_TRUE(is_tunable(Sustained::Parameters{1}));
    EXPECT_TRUE(is_tunable(SlowlyAdapting<Sustained>::Parameters{{1, 0}, 0.3, 8s}));
    EXPECT_TRUE(is_tunable(DynamicSustained::Parameters{1, 0, 20ms, 50}));
    EXPECT_TRUE(is_tunable(Transient::Parameters{1, 0, {.negative_ratio = 0}}));
    EXPECT_FALSE(is_tunable(Transient::Parameters{1, 0, {.threshold = 1}}));
    EXPECT_FALSE(is_tunable(BandTransient::Parameters{1, 0, 50, {.threshold = 1}}));
    EXPECT_FALSE(is_tunable(Vibration::Parameters{1, 0, 50}));
}

TEST(Encoders, AreNamedAsInScenes) {
    EXPECT_EQ(std::string(name(Sustained::Parameters{1})), "sustained");
    EXPECT_EQ(std::string(name(Transient::Parameters{1})), "transient");
    EXPECT_EQ(std::string(name(Vibration::Parameters{1, 0, 250})), "vibration");
    EXPECT_EQ(std::string(gain_name(Vibration::Parameters{1, 0, 250})), "gain_mv_s2_per_n");
}

}  // namespace
}  // namespace afferent
