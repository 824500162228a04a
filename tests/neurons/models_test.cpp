#include "afferent/neurons/models.hpp"

#include <gtest/gtest.h>

#include "afferent/neurons/sparse_population.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

TEST(NeuronModels, GiveTheClassThatComputesLeast) {
    EXPECT_TRUE(std::holds_alternative<Lif>(smallest_model(LifParameters{.delta_g = 0})));
    EXPECT_TRUE(std::holds_alternative<Refractory<Lif>>(
        smallest_model(LifParameters{.delta_g = 0, .refractory_ms = 1})));
    EXPECT_TRUE(std::holds_alternative<AdaptingLif>(smallest_model(LifParameters{})));
    EXPECT_TRUE(
        std::holds_alternative<Refractory<AdaptingLif>>(smallest_model(LifParameters{.refractory_ms = 1})));
}

TEST(NeuronModels, AreCheckedByTheirOwnRules) {
    EXPECT_NO_THROW(check(NeuronModel{}));
    EXPECT_THROW(check(LifParameters{.tau_m_ms = 0}), ParameterError);
    EXPECT_THROW(smallest_model(LifParameters{.tau_m_ms = 0}), ParameterError);
}

TEST(NeuronModels, AtRestAreNotInTheirRefractoryPeriod) {
    const Refractory<Lif> neuron(LifParameters{.delta_g = 0, .refractory_ms = 1});
    EXPECT_EQ(neuron.rest().left, Interval(0));
    EXPECT_EQ(neuron.at_phase(0.5).left, Interval(0));
}

TEST(NeuronModels, TellOfThemselves) {
    const NeuronModel model = LifParameters{.delta_g = 0.5, .refractory_ms = 2};
    EXPECT_STREQ(name(model), "lif");
    EXPECT_EQ(describe(model),
              "tau_m_ms 10, tau_g_ms 100, v_r_mv -65, v_th_mv -50, e_k_mv -70, delta_g 0.5, refractory_ms 2");
    EXPECT_EQ(adaptation(model), 0.5);
    EXPECT_EQ(refractory(model), Milliseconds(2));
    EXPECT_EQ(adaptation(with_adaptation(model, 0.25)), 0.25);
    EXPECT_STREQ(name(FixedPointParameters{}), "fixed_point");
    EXPECT_EQ(bytes_per_neuron(LifParameters{.delta_g = 0}), SparsePopulation<Lif>::bytes_per_neuron);
}

}  // namespace
}  // namespace afferent
