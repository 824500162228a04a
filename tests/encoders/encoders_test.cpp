// Laws of every encoder of the list.
#include "afferent/encoders/encoders.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <type_traits>
#include <variant>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

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
        return E::Parameters::with(gain, bias_mv);
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

// A force, or a slope, of 3 and one of 6.
TYPED_TEST(EncoderLaws, DriveInProportionToTheirInput) {
    const EncoderParameters parameters = this->parameters(2, 5);
    const bool of_force = input(parameters) == EncoderInput::force;
    visit_encoder(parameters, [&]<Encoder E>(const E& encoder) {
        typename E::State state;
        encoder.drive_mv(state, scene_start, 0);
        EXPECT_DOUBLE_EQ(encoder.drive_mv(state, scene_start + 1s, 3), 11);
        EXPECT_DOUBLE_EQ(encoder.drive_mv(state, scene_start + 2s, of_force ? 6 : 9), 17);
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

TEST(Encoders, AreNamedAsInScenes) {
    EXPECT_EQ(std::string(name(Sustained::Parameters{1})), "sustained");
    EXPECT_EQ(std::string(name(Transient::Parameters{1})), "transient");
}

}  // namespace
}  // namespace afferent
