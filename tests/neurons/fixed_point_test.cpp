#include "afferent/neurons/fixed_point.hpp"

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "afferent/neurons/adapting_lif.hpp"
#include "afferent/neurons/rate.hpp"
#include "afferent/neurons/sparse_population.hpp"
#include "afferent/runtime/event.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "tests/neurons/model_types.hpp"

namespace afferent {
namespace {

using boost::multiprecision::cpp_int;
using boost::multiprecision::cpp_rational;

std::string fixed_point_refusal(const FixedPointParameters& parameters) {
    try {
        parameters.check();
    } catch (const ParameterError& error) {
        return error.what();
    }
    return "accepted";
}

// The header's formula on integers without a width, where rounding is a comparison of fractions. Its
// constants are computed here once more, from the parameters.
class Emulation {
  public:
    explicit Emulation(const FixedPointParameters& p) : p_(p) {
        const double low_mv = std::min(p.lif.v_r_mv, p.lif.e_k_mv);
        v_unit_mv = (p.lif.v_th_mv - low_mv) / (7 * std::pow(2.0, p.state_bits) / 8);
        const double interval_ms = p.lif.refractory_ms > 4 ? p.lif.refractory_ms : 4;
        g_unit =
            p.lif.delta_g / (1 - std::exp(-interval_ms / p.lif.tau_g_ms)) / (std::pow(2.0, p.state_bits) - 1);
        const double h_ms = p.tick_us / 1e3;
        one = cpp_int(1) << p.decay_bits;
        v_decay = std::llround(std::exp(-h_ms / p.lif.tau_m_ms) * std::pow(2.0, p.decay_bits));
        g_decay = std::llround(std::exp(-h_ms / p.lif.tau_g_ms) * std::pow(2.0, p.decay_bits));
        threshold = std::llround((p.lif.v_th_mv - p.lif.e_k_mv) / v_unit_mv);
        reset = std::llround((p.lif.v_r_mv - p.lif.e_k_mv) / v_unit_mv);
        u = reset;
        if (p.lif.delta_g == 0) return;
        g_jump = std::llround(p.lif.delta_g / g_unit);
        // The largest power of two that leaves K below one.
        const double share = (std::exp(h_ms / p.lif.tau_m_ms) - 1) * g_unit;
        while (share * std::pow(2.0, conductance_bits + 1) < 1 && conductance_bits + p.decay_bits < 62)
            ++conductance_bits;
        conductance = std::llround(share * std::pow(2.0, conductance_bits + p.decay_bits));
    }

    // True at a spike.
    bool tick(double drive_mv) {
        const cpp_int most = (cpp_int(1) << p_.state_bits) - 1;
        g = divided(g * g_decay, one);
        const cpp_int taken = divided(g * conductance, cpp_int(1) << conductance_bits);
        const cpp_int kept = taken > one ? cpp_int(0) : cpp_int(one - taken);
        if (rests > 0) {
            --rests;
            return false;
        }
        cpp_int b = std::llround((p_.lif.v_r_mv + drive_mv - p_.lif.e_k_mv) / v_unit_mv);
        const cpp_int input_end = cpp_int(1) << (p_.state_bits + 4);
        if (b > input_end - 1) b = input_end - 1;
        if (b < -input_end) b = -input_end;
        u = divided(divided(u * kept, one) * v_decay + b * (one - v_decay), one);
        const cpp_int lowest = reset < 0 ? reset : cpp_int(0);
        if (u < lowest) u = lowest;
        if (u > lowest + most) u = lowest + most;
        if (u < threshold) return false;
        u = reset;
        g = g + g_jump > most ? most : cpp_int(g + g_jump);
        rests = std::llround(p_.lif.refractory_ms * 1000 / p_.tick_us);
        return true;
    }

    double v_unit_mv, g_unit;
    cpp_int one, v_decay, g_decay, threshold, reset, g_jump, conductance, u, g;
    unsigned conductance_bits = 0;
    long long rests = 0;

  private:
    cpp_int divided(const cpp_int& product, const cpp_int& by) const {
        const cpp_int remainder = ((product % by) + by) % by;
        const cpp_int below = (product - remainder) / by;
        if (p_.rounding == Rounding::truncation) return below;
        const cpp_rational part(remainder, by);
        const cpp_rational half(1, 2);
        if (part == half) return below % 2 == 0 ? below : cpp_int(below + 1);
        return part > half ? cpp_int(below + 1) : below;
    }

    FixedPointParameters p_;
};

TEST(FixedPointLif, IsItsFormulaTickByTick) {
    std::mt19937_64 random(5);
    int spikes = 0;
    for (int i = 0; i < 60; ++i) {
        FixedPointParameters parameters = ParametersFor<FixedPointLif>::random(random);
        if (i % 3 == 0) parameters.state_bits = 8 + static_cast<std::uint32_t>(random() % 6);
        if (fixed_point_refusal(parameters) != "accepted") continue;
        const FixedPointLif neuron(parameters);
        Emulation emulation(parameters);
        FixedPointLif::State state = neuron.rest();
        const Interval tick(parameters.tick_us * 1000.0);
        double drive_mv = 0;
        for (int k = 0; k < 600; ++k) {
            if (k % 50 == 0) drive_mv = uniform(random, -100, 2000 / (1.0 + k % 7));
            const bool due = neuron.next_spike(state, drive_mv) == tick;
            neuron.advance(state, drive_mv, tick);
            if (due) neuron.fire(state);
            ASSERT_EQ(due, emulation.tick(drive_mv)) << i << ' ' << k;
            ASSERT_EQ(state.u, emulation.u) << i << ' ' << k;
            ASSERT_EQ(state.g, emulation.g) << i << ' ' << k;
            spikes += due ? 1 : 0;
        }
    }
    EXPECT_GT(spikes, 1000);
}

// A tick halves g, which jumps by a third of its 15 codes, and takes u half of the way to its input.
TEST(FixedPointLif, RoundsATieToEven) {
    const double tau_ms = 4 / std::log(1.5);
    const auto tick_us = static_cast<std::uint32_t>(std::lround(1000 * tau_ms * std::log(2)));
    FixedPointParameters parameters{.lif = {.tau_m_ms = tau_ms, .tau_g_ms = tau_ms, .delta_g = 0.3},
                                    .tick_us = tick_us,
                                    .state_bits = 4,
                                    .decay_bits = 4};
    const Interval tick(tick_us * 1e3);
    {
        const FixedPointLif neuron(parameters);
        FixedPointLif::State state = neuron.rest();
        neuron.fire(state);
        EXPECT_EQ(state.g, 5U);
        for (const std::uint32_t expected : {2U, 1U, 0U}) {  // 2.5, 1 and 0.5
            neuron.advance(state, 0, tick);
            EXPECT_EQ(state.g, expected);
        }
    }
    parameters.lif.delta_g = 0;
    const FixedPointLif neuron(parameters);
    FixedPointLif::State state = neuron.rest();
    ASSERT_EQ(state.u, 4);
    const double unit_mv = 20 / 14.0;
    for (const std::int64_t expected : {6, 8, 8}) {  // 6.5, 7.5 and 8.5 on the way to 9
        neuron.advance(state, 5.5 * unit_mv, tick);
        EXPECT_EQ(state.u, expected);
    }
}

// Interspike intervals of an adapting neuron, in ms, from rest.
template <Neuron N>
std::vector<double> intervals_ms(const N& neuron, double drive_mv, int count) {
    std::vector<double> intervals;
    typename N::State state = neuron.rest();
    for (int i = 0; i < count; ++i) {
        const Interval span = neuron.next_spike(state, drive_mv);
        neuron.advance(state, drive_mv, span);
        neuron.fire(state);
        intervals.push_back(Milliseconds(span).count());
    }
    return intervals;
}

const LifParameters adapting{.delta_g = 0.3};

double rms_apart_ms(const FixedPointParameters& parameters, const auto& reference) {
    double sum = 0;
    int count = 0;
    for (double drive = 30; drive < 60; drive += 0.7) {
        const std::vector<double> truth = intervals_ms(reference, drive, 8);
        const std::vector<double> ours = intervals_ms(FixedPointLif(parameters), drive, 8);
        for (std::size_t i = 0; i < truth.size(); ++i) {
            sum += (ours[i] - truth[i]) * (ours[i] - truth[i]);
            ++count;
        }
    }
    return std::sqrt(sum / count);
}

// Both the step's own error and the rounding of a spike to its tick are of first order.
TEST(FixedPointLif, ConvergesToTheExactNeuronWithItsTick) {
    FixedPointParameters parameters{.lif = adapting, .tick_us = 1000, .state_bits = 32, .decay_bits = 24};
    const AdaptingLif exact(adapting);
    const double coarse_ms = rms_apart_ms(parameters, exact);
    parameters.tick_us = 62;
    const double fine_ms = rms_apart_ms(parameters, exact);
    EXPECT_NEAR(std::log(coarse_ms / fine_ms) / std::log(1000.0 / 62), 1, 0.15);
    // Half a tick or so.
    EXPECT_LT(coarse_ms, 1);
}

// Every bit halves the unit that rounding works in: how far the rheobase is off halves with it, and
// interspike intervals follow until they differ from those of the widest integers by a tick now and then.
TEST(FixedPointLif, ConvergesWithItsBits) {
    const FixedPointParameters finest{.lif = adapting, .tick_us = 500, .state_bits = 32, .decay_bits = 24};
    const auto with_bits = [&](std::uint32_t bits) {
        FixedPointParameters parameters = finest;
        parameters.state_bits = bits;
        return parameters;
    };
    const auto miss_mv = [&](std::uint32_t bits) { return rheobase_mv(with_bits(bits)) - 15; };
    for (const std::uint32_t bits : {8U, 12U, 16U})
        EXPECT_NEAR(std::log2(miss_mv(bits) / miss_mv(bits + 4)), 4, 0.5) << bits;
    const FixedPointLif reference(finest);
    const double rough_ms = rms_apart_ms(with_bits(13), reference);
    const double fine_ms = rms_apart_ms(with_bits(22), reference);
    EXPECT_LT(fine_ms, 0.1 * rough_ms);
}

// A shift alone loses half a unit on the average, in every product and always downwards: v comes late to the
// threshold.
TEST(FixedPointLif, IsLaterAndFurtherOffWithTruncation) {
    FixedPointParameters parameters{.lif = adapting, .state_bits = 14, .decay_bits = 20};
    const AdaptingLif exact(adapting);
    const double even_ms = rms_apart_ms(parameters, exact);
    const double first_even_ms = intervals_ms(FixedPointLif(parameters), 17, 1).front();
    const double rheobase_even_mv = rheobase_mv(parameters);
    parameters.rounding = Rounding::truncation;
    EXPECT_GT(rms_apart_ms(parameters, exact), 1.5 * even_ms);
    EXPECT_GT(intervals_ms(FixedPointLif(parameters), 17, 1).front(), first_even_ms);
    EXPECT_GT(rheobase_mv(parameters), rheobase_even_mv);
}

// What a tick would move by less than half a unit does not move: with a short tick the resting point is
// missed by up to half a unit over 1 − D_m.
TEST(FixedPointLif, StopsWhereATickIsLessThanHalfAUnit) {
    const FixedPointParameters parameters{
        .lif = {.delta_g = 0}, .tick_us = 100, .state_bits = 8, .decay_bits = 24};
    const FixedPointLif neuron(parameters);
    const Emulation scale(parameters);
    const double dead_zone_mv = 0.5 * scale.v_unit_mv / -std::expm1(-0.01);
    FixedPointLif::State state = neuron.rest();
    neuron.advance(state, 10, Interval(1e9));
    EXPECT_NEAR(neuron.v_mv(state), -65 + 10 - dead_zone_mv, scale.v_unit_mv);
    EXPECT_NEAR(rheobase_mv(parameters), 15 + dead_zone_mv, 2 * scale.v_unit_mv);
}

TEST(FixedPointLif, SaturatesInsteadOfWrapping) {
    // One tick takes v almost two thirds of the way.
    const FixedPointParameters parameters{.lif = {.delta_g = 0.3}, .tick_us = 10'000, .state_bits = 8};
    const FixedPointLif neuron(parameters);
    const Emulation scale(parameters);
    FixedPointLif::State state = neuron.rest();
    for (const double drive_mv : {1e3, 1e9, 1e300, std::numeric_limits<double>::max()}) {
        neuron.advance(state, drive_mv, Interval(1e7));
        EXPECT_NEAR(neuron.v_mv(state), -70 + 255 * scale.v_unit_mv, 1e-9) << "the top of v";
        neuron.advance(state, -drive_mv, Interval(1e7));
        EXPECT_EQ(neuron.v_mv(state), -70) << "the bottom of v";
    }
    double before = 0;
    for (int i = 0; i < 1000; ++i) {
        neuron.fire(state);
        EXPECT_GE(neuron.g(state), before);
        before = neuron.g(state);
    }
    EXPECT_NEAR(before, 255 * scale.g_unit, 1e-12);
    neuron.advance(state, 0, Interval(1e7));
    EXPECT_LT(neuron.g(state), before);
}

TEST(FixedPointLif, FiresAtTicksAndTakesADriveFromTheNext) {
    const FixedPointParameters parameters{.tick_us = 500};
    SparsePopulation<FixedPointLif> population(FixedPointLif(parameters), 2);
    std::vector<Event> events;
    const auto sink = [&](TimePoint time, std::uint32_t index) { events.push_back({time, index}); };
    // The one at the tick, before it is due, the other just after the tick before.
    population.advance(scene_start + 1us, sink);
    population.set_drive(0, scene_start + 1us, 60);
    population.advance(scene_start + 499us, sink);
    population.set_drive(1, scene_start + 499us, 60);
    population.advance(scene_start + 300ms, sink);
    ASSERT_GT(events.size(), 10U);
    for (std::size_t i = 0; i < events.size(); i += 2) {
        EXPECT_EQ((events[i].time - scene_start) % 500us, 0ns);
        EXPECT_EQ(events[i].time, events[i + 1].time);
    }
}

// Work ends where the state does not move any more: a span of decades and a prediction from there are as
// cheap as the ticks until then.
TEST(FixedPointLif, CostsNothingOnceItHasSettled) {
    const FixedPointLif neuron({.tick_us = 1});
    FixedPointLif::State state = neuron.rest();
    for (int i = 0; i < 5; ++i) neuron.fire(state);
    neuron.advance(state, 10, Interval(1e18));
    FixedPointLif::State later = state;
    for (int i = 0; i < 1'000'000; ++i) {
        neuron.advance(later, 10, Interval(1e15));
        ASSERT_EQ(neuron.next_spike(later, 10), never);
    }
    EXPECT_EQ(later, state);
}

TEST(FixedPointLif, FindsThatNoSpikeWillComeWithinItsBound) {
    std::mt19937_64 random(7);
    for (int i = 0; i < 100; ++i) {
        const FixedPointParameters p = ParametersFor<FixedPointLif>::random(random);
        const FixedPointLif neuron(p);
        FixedPointLif::State state = neuron.rest();
        for (int k = 0; k < 50; ++k) neuron.fire(state);
        const double drive_mv = uniform(random, -30, 1) + rheobase_mv(p);
        const double tau_ms = p.lif.tau_m_ms + p.lif.tau_g_ms;
        // One and a half times the header's, which counts v and g one after the other.
        const double bound_ms =
            p.lif.refractory_ms + 1.5 * tau_ms * (p.state_bits * std::log(2) + 1) + p.tick_us / 1e3;
        FixedPointLif::State settled = state;
        neuron.advance(settled, drive_mv, std::chrono::ceil<Duration>(Milliseconds(bound_ms)));
        if (neuron.next_spike(state, drive_mv) != never) continue;
        FixedPointLif::State later = settled;
        neuron.advance(later, drive_mv, Interval(p.tick_us * 1e3));
        EXPECT_EQ(later, settled) << i;
    }
}

TEST(FixedPointLif, IsTunedLikeEveryModel) {
    const FixedPointParameters parameters{.tick_us = 100, .state_bits = 24, .decay_bits = 24};
    const double drive = drive_mv(RateKind::steady, parameters, 100);
    EXPECT_GE(rate_hz(RateKind::steady, parameters, drive), 100);
    EXPECT_LT(rate_hz(RateKind::steady, parameters, drive * (1 - 1e-3)), 100);
    // The exact neuron's, within a tick in 10 ms.
    EXPECT_NEAR(drive, drive_mv(RateKind::steady, LifParameters{}, 100), 0.02 * drive);
}

TEST(FixedPointParameters, RefuseWhatCannotBeComputed) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(fixed_point_refusal({}), "accepted");
    EXPECT_EQ(fixed_point_refusal({.lif = {.tau_m_ms = nan}}), "tau_m_ms must be > 0, is nan");
    EXPECT_EQ(fixed_point_refusal({.tick_us = 0}), "tick_us must be 1 to 10000, is 0");
    EXPECT_EQ(fixed_point_refusal({.tick_us = 10'001}), "tick_us must be 1 to 10000, is 10001");
    for (const std::uint32_t bits : {0U, 3U, 33U, std::numeric_limits<std::uint32_t>::max()})
        EXPECT_NE(fixed_point_refusal({.state_bits = bits}), "accepted");
    for (const std::uint32_t bits : {0U, 3U, 25U})
        EXPECT_NE(fixed_point_refusal({.decay_bits = bits}), "accepted");
    EXPECT_NE(fixed_point_refusal({.rounding = static_cast<Rounding>(2)}), "accepted");
    EXPECT_EQ(fixed_point_refusal({.tick_us = 100, .decay_bits = 8}),
              "decay_bits must be enough to tell a tick's decay of g, e^(-tick/tau_g), from none, is 8");
    EXPECT_EQ(fixed_point_refusal({.tick_us = 1, .decay_bits = 8}),
              "decay_bits must be enough to tell a tick's decay of v, e^(-tick/tau_m), from none, is 8");
    EXPECT_EQ(fixed_point_refusal({.lif = {.tau_g_ms = 1e5}, .tick_us = 10'000, .state_bits = 8}),
              "state_bits must be enough to tell delta_g from 0, is 8");
    EXPECT_EQ(fixed_point_refusal({.lif = {.v_r_mv = -50.01}, .state_bits = 8}),
              "state_bits must be enough to tell v_r from v_th, is 8");
    EXPECT_EQ(fixed_point_refusal({.lif = {.e_k_mv = -50.001}, .state_bits = 8}),
              "state_bits must be enough to tell E_k from v_th, is 8");
}

}  // namespace
}  // namespace afferent
