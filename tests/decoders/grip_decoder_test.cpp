#include "afferent/decoders/grip_decoder.hpp"

#include <gtest/gtest.h>

#include "afferent/decoders/decoders.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "tests/decoders/afferents.hpp"

namespace afferent {
namespace {

template <class D>
void expect_same(const typename D::Parameters& parameters) {
    GripDecoder chosen = make_decoder(parameters, fingertips());
    D own(parameters, fingertips());
    EXPECT_EQ(chosen.history(), own.history());
    for (const Step& step : random_stream(9, 100, 5)) ASSERT_EQ(take(chosen, step), take(own, step));
}

TEST(GripDecoder, IsTheDecoderWhoseParametersItWasGiven) {
    expect_same<SlidingWindow>({.window = 50ms});
    expect_same<Exponential>({.time_constant = 30ms, .pooling = Pooling::per_neuron});
    expect_same<InverseInterval>({.pooling = Pooling::per_neuron});
    expect_same<Inversion>({});
    expect_same<Filter>({});
}

TEST(GripDecoder, RefusesASnapshotOfAnotherDecoderAndStaysAsItWas) {
    GripDecoder window = make_decoder(SlidingWindowParameters(), fingertips());
    const GripDecoder exponential = make_decoder(ExponentialParameters(), fingertips());
    for (const Step& step : random_stream(9, 20, 5)) take(window, step);
    const auto before = window.snapshot();
    EXPECT_THROW(window.resume(exponential.snapshot()), ParameterError);
    EXPECT_EQ(window.snapshot(), before);
}

}  // namespace
}  // namespace afferent
