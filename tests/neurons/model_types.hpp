// Every class of neuron that the list of models names, for typed tests: TYPED_TEST_SUITE(Name, NeuronTypes).
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <iterator>
#include <random>
#include <type_traits>
#include <variant>

#include "afferent/neurons/models.hpp"

namespace afferent {

template <class Variant>
struct TypesOf;
template <class... N>
struct TypesOf<std::variant<N...>> {
    using Types = testing::Types<N...>;
    static_assert((Neuron<N> && ...));
};
using NeuronTypes = TypesOf<AnyNeuron>::Types;

inline double uniform(std::mt19937_64& random, double low, double high) {
    return std::uniform_real_distribution<>(low, high)(random);
}

// Parameters that the class takes. A new model is tested with its defaults until it says here what to vary.
template <class N>
struct ParametersFor {
    static typename N::Parameters random(std::mt19937_64&) { return {}; }
};

template <class N>
concept ExactNeuron = std::is_same_v<typename N::Parameters, LifParameters>;

template <ExactNeuron N>
struct ParametersFor<N> {
    static constexpr bool adapts =
        std::is_same_v<N, AdaptingLif> || std::is_same_v<N, Refractory<AdaptingLif>>;
    static constexpr bool rests =
        std::is_same_v<N, Refractory<Lif>> || std::is_same_v<N, Refractory<AdaptingLif>>;
    static LifParameters random(std::mt19937_64& random) {
        LifParameters p;
        p.tau_m_ms = uniform(random, 1, 30);
        p.tau_g_ms = std::exp(uniform(random, std::log(0.01), std::log(1e4)));
        p.delta_g = adapts ? std::exp(uniform(random, std::log(0.01), std::log(30))) : 0;
        p.refractory_ms = rests ? uniform(random, 0.5, 5) : 0;
        return p;
    }
};

// Ticks divide 1e9 s, so that a run may begin that much later.
template <>
struct ParametersFor<FixedPointLif> {
    static FixedPointParameters random(std::mt19937_64& random) {
        FixedPointParameters p;
        p.lif.tau_m_ms = uniform(random, 1, 30);
        p.lif.tau_g_ms = std::exp(uniform(random, std::log(1), std::log(1000)));
        p.lif.delta_g =
            uniform(random, 0, 1) < 0.2 ? 0 : std::exp(uniform(random, std::log(0.01), std::log(3)));
        p.lif.e_k_mv = uniform(random, -90, -55);
        p.lif.refractory_ms = uniform(random, 0, 1) < 0.5 ? 0 : uniform(random, 0.5, 5);
        constexpr std::uint32_t ticks_us[] = {50, 100, 200, 250, 500, 1000};
        p.tick_us = ticks_us[random() % std::size(ticks_us)];
        p.state_bits = 14 + static_cast<std::uint32_t>(random() % 19);
        p.decay_bits = 16 + static_cast<std::uint32_t>(random() % 9);
        p.rounding = random() % 2 == 0 ? Rounding::half_even : Rounding::truncation;
        return p;
    }
};

}  // namespace afferent
