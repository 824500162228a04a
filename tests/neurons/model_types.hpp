// The closed list of models, for typed tests: TYPED_TEST_SUITE(Name, ModelTypes).
#pragma once

#include <gtest/gtest.h>

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
using ModelTypes = TypesOf<NeuronModel>::Types;

}  // namespace afferent
