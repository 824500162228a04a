#include "afferent/decoders/outputs.hpp"

#include <type_traits>

namespace afferent {
namespace {

// The first of the list that has such parameters.
template <class Parameters, class First, class... Rest>
Outputs::Any make(OutputList<First, Rest...>, const Parameters& parameters) {
    if constexpr (std::is_same_v<Parameters, typename First::Parameters>)
        return Outputs::Any(std::in_place_type<First>, parameters);
    else
        return make(OutputList<Rest...>(), parameters);
}

}  // namespace

GripOutput::GripOutput(const Parameters& parameters)
    : output_(std::visit([](const auto& own) { return make(Outputs(), own); }, parameters)) {}

GripCommand GripOutput::operator()(TimePoint now, const Estimate& estimate, GripState state,
                                   const Effort& effort) {
    return std::visit([&](auto& output) { return output(now, estimate, state, effort); }, output_);
}

}  // namespace afferent
