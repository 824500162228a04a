#include "afferent/neurons/sparse_population.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "afferent/neurons/models.hpp"
#include "afferent/runtime/event.hpp"
#include "bench/reference.hpp"
#include "tests/neurons/model_types.hpp"
#include "tests/since_start.hpp"

namespace afferent {
namespace {

using reference::Real;

struct Step {
    Duration time;
    double drive_mv;
};

std::vector<Step> random_drive(unsigned seed, Duration every, Duration until) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<> drive(-10, 120);
    std::vector<Step> steps;
    for (Duration time{}; time < until; time += every) steps.push_back({time, drive(random)});
    return steps;
}

template <class Population>
std::vector<Event> run(Population& population, const std::vector<Step>& steps, TimePoint until,
                       Duration window = 1h) {
    std::vector<Event> events;
    const auto sink = [&](TimePoint time, std::uint32_t index) { events.push_back({time, index}); };
    TimePoint reached = scene_start;
    const auto advance = [&](TimePoint to) {
        while (reached < to) {
            reached = std::min(to, reached + window);
            population.advance(reached, sink);
        }
    };
    for (const Step& step : steps) {
        advance(at(step.time));
        for (std::uint32_t i = 0; i < population.size(); ++i)
            population.set_drive(i, at(step.time), step.drive_mv * (i + 1.0));
    }
    advance(until);
    return events;
}

std::vector<Real> true_spikes_s(const LifParameters& parameters, const std::vector<Step>& steps,
                                Real until_s) {
    const reference::Neuron neuron(parameters);
    reference::State state = neuron.rest();
    std::vector<Real> spikes;
    Real time = 0;
    Real blocked_until = 0;
    for (std::size_t i = 0; i < steps.size(); ++i) {
        const Real end = i + 1 < steps.size() ? Real(steps[i + 1].time.count()) / 1'000'000'000 : until_s;
        while (time < end) {
            if (blocked_until > time) {
                const Real held = (blocked_until < end ? blocked_until : end) - time;
                neuron.hold(state, held);
                time += held;
                continue;
            }
            const auto span = neuron.next_spike_s(state, steps[i].drive_mv);
            if (!span || time + *span > end) {
                state = neuron.advance(state, steps[i].drive_mv, end - time);
                time = end;
                break;
            }
            state = neuron.advance(state, steps[i].drive_mv, *span);
            neuron.fire(state);
            time += *span;
            blocked_until = time + neuron.refractory_s();
            spikes.push_back(time);
        }
    }
    return spikes;
}

template <class N>
class SparsePopulationOf : public testing::Test {};

TYPED_TEST_SUITE(SparsePopulationOf, NeuronTypes);

// Parameters that the class takes.
template <class N>
typename N::Parameters parameters_of() {
    return {};
}
template <ExactNeuron N>
LifParameters parameters_of() {
    return {.delta_g = ParametersFor<N>::adapts ? 0.6 : 0,
            .refractory_ms = ParametersFor<N>::rests ? 1.5 : 0};
}

template <class N>
class SparsePopulationOfExact : public testing::Test {};
using ExactTypes = TypesOf<decltype(smallest_neuron(LifParameters{}))>::Types;
TYPED_TEST_SUITE(SparsePopulationOfExact, ExactTypes);

TYPED_TEST(SparsePopulationOfExact, FiresWithinANanosecondOfTheTruth) {
    const auto parameters = parameters_of<TypeParam>();
    SparsePopulation<TypeParam> population(TypeParam(parameters), 1);
    const auto steps = random_drive(1, 5ms, 300ms);
    const auto events = run(population, steps, at(300ms));
    const auto truth = true_spikes_s(parameters, steps, Real(3) / 10);
    ASSERT_GT(truth.size(), 5U);
    ASSERT_EQ(events.size(), truth.size());
    // A stamp is the spike rounded up, and the neuron's own error is far below.
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const auto late_ns =
            static_cast<double>(Real(events[i].time.time_since_epoch().count()) - truth[i] * 1'000'000'000);
        EXPECT_GT(late_ns, -1e-5);
        EXPECT_LT(late_ns, 1 + 1e-5);
    }
}

TYPED_TEST(SparsePopulationOf, GivesTheSameEventsForAnyWindow) {
    const TypeParam neuron(parameters_of<TypeParam>());
    const auto steps = random_drive(2, 5ms, 500ms);
    SparsePopulation<TypeParam> whole(neuron, 3);
    const auto expected = run(whole, steps, at(600ms));
    EXPECT_TRUE(std::is_sorted(expected.begin(), expected.end()));
    for (const Duration window : {Duration(7919), Duration(100us), Duration(5ms)}) {
        SparsePopulation<TypeParam> cut(neuron, 3);
        EXPECT_EQ(run(cut, steps, at(600ms), window), expected);
    }
}

TYPED_TEST(SparsePopulationOf, IgnoresADriveThatAlreadyHolds) {
    const TypeParam neuron(parameters_of<TypeParam>());
    SparsePopulation<TypeParam> once(neuron, 2);
    const std::vector<Step> held{{0ms, 40}};
    const auto expected = run(once, held, at(500ms));
    std::vector<Step> repeated;
    for (int i = 0; i < 100; ++i) repeated.push_back({i * 3ms, 40});
    SparsePopulation<TypeParam> often(neuron, 2);
    EXPECT_EQ(run(often, repeated, at(500ms)), expected);
}

TYPED_TEST(SparsePopulationOf, ResetEqualsFresh) {
    const TypeParam neuron(parameters_of<TypeParam>());
    const auto steps = random_drive(3, 5ms, 200ms);
    SparsePopulation<TypeParam> population(neuron, 2);
    const auto first = run(population, steps, at(300ms));
    population.reset();
    EXPECT_EQ(run(population, steps, at(300ms)), first);
}

// Without adaptation v approaches v_r + R·I along an exponential, from wherever it begins.
TEST(SparsePopulation, BeginsAtThePhasesOfItsNeurons) {
    const LifParameters parameters{.delta_g = 0};
    const std::vector<double> phases{0, 0.25, 0.9};
    const double gap_mv = parameters.v_th_mv - parameters.v_r_mv;
    const double drive_mv = 2 * gap_mv;
    SparsePopulation<Lif, Individual<Lif>> population(
        Individual<Lif>(std::vector<LifParameters>(phases.size(), parameters),
                        [&](std::uint32_t i) { return phases[i]; }),
        phases.size());
    for (int repeated = 0; repeated < 2; ++repeated) {
        std::vector<TimePoint> first(phases.size(), scene_start);
        for (std::uint32_t i = 0; i < phases.size(); ++i) population.set_drive(i, scene_start, drive_mv);
        population.advance(at(10ms), [&](TimePoint time, std::uint32_t index) {
            if (first[index] == scene_start) first[index] = time;
        });
        for (std::size_t i = 0; i < phases.size(); ++i) {
            const double expected_ms =
                parameters.tau_m_ms * std::log((drive_mv - phases[i] * gap_mv) / (drive_mv - gap_mv));
            EXPECT_NEAR(seconds(first[i]) * 1000, expected_ms, 1.1e-6)
                << "a stamp is rounded up to a nanosecond";
        }
        population.reset();
    }
}

// A stamp is rounded up to a nanosecond; who asks for it is told by how much.
TEST(SparsePopulation, TellsTheTimeFromASpikeToItsStamp) {
    const LifParameters parameters{.delta_g = 0};
    const double gap_mv = parameters.v_th_mv - parameters.v_r_mv;
    SparsePopulation<Lif> population(Lif(parameters), 1);
    population.set_drive(0, scene_start, 3 * gap_mv);
    const double period_ns = parameters.tau_m_ms * 1e6 * std::log(1.5) + parameters.refractory_ms * 1e6;
    int spikes = 0;
    population.advance(at(100ms), [&](TimePoint time, std::uint32_t, Interval early) {
        const double spike_ns = static_cast<double>((time - scene_start).count()) + early.count();
        ++spikes;
        EXPECT_NEAR(spike_ns, spikes * period_ns, 1e-3 * spikes);
    });
    EXPECT_GT(spikes, 10);
}

TEST(SparsePopulation, LetsANeuronFireAsOftenAsTheLimitInEveryWindow) {
    std::vector<std::uint32_t> spikes(100);
    const auto storms_beyond = [&](std::uint32_t most) {
        SparsePopulation<AdaptingLif> population(AdaptingLif({.delta_g = 0}), 1,
                                                 {.spikes = most, .window = 50ms});
        population.set_drive(0, scene_start, 40);
        population.advance(at(5s) - Duration(1),
                           [&](TimePoint time, std::uint32_t) { ++spikes[(time - scene_start) / 50ms]; });
        return population.storm().has_value();
    };
    ASSERT_FALSE(storms_beyond(1000));
    const std::uint32_t most = *std::ranges::max_element(spikes);
    ASSERT_GT(most, 2U);
    ASSERT_LT(spikes.front(), most) << "the first window tells nothing of the next";
    EXPECT_FALSE(storms_beyond(most));
    EXPECT_TRUE(storms_beyond(most - 1));
}

TEST(SparsePopulation, FiresNothingWhileItIsSuspended) {
    SparsePopulation<AdaptingLif> population(AdaptingLif({.delta_g = 0}), 1,
                                             {.spikes = 1000, .window = 50ms});
    population.set_drive(0, scene_start, 40);
    population.suspend();
    int spikes = 0;
    population.advance(at(1s), [&](TimePoint, std::uint32_t) { ++spikes; });
    EXPECT_EQ(spikes, 0);
}

TEST(SparsePopulation, StopsANeuronThatStorms) {
    SparsePopulation<AdaptingLif> population(AdaptingLif({.delta_g = 0}), 2, {.spikes = 100, .window = 5ms});
    std::vector<Event> events;
    population.set_drive(1, scene_start, 1e9);
    population.advance(at(1s), [&](TimePoint time, std::uint32_t index) { events.push_back({time, index}); });
    ASSERT_TRUE(population.storm());
    EXPECT_EQ(population.storm()->index, 1U);
    EXPECT_EQ(events.size(), 101U);
    population.reset();
    EXPECT_FALSE(population.storm());
}

TEST(SparsePopulation, RefusesALimitOfNoTime) {
    for (const Duration window : {Duration(0), Duration(-1)}) {
        try {
            (void)SparsePopulation<AdaptingLif>(AdaptingLif(AdaptingLif::Parameters{}), 1,
                                                {.window = window});
            ADD_FAILURE() << "accepted";
        } catch (const ParameterError& error) {
            EXPECT_EQ(error.field(), "window");
        }
    }
}

TEST(SparsePopulation, CountsTheBytesThatItTakesBeforeItIsBuilt) {
    const auto bytes = [](std::size_t count) {
        return SparsePopulation<AdaptingLif>(AdaptingLif(AdaptingLif::Parameters{}), count).bytes();
    };
    EXPECT_EQ(SparsePopulation<AdaptingLif>::size_of(10), bytes(10));
    using Differing = SparsePopulation<AdaptingLif, Individual<AdaptingLif>>;
    EXPECT_EQ(Differing::size_of(10) - Differing::size_of(9) - (bytes(10) - bytes(9)), sizeof(AdaptingLif));
    EXPECT_EQ(bytes(1000) - bytes(100), 900 * (bytes(1) - bytes(0)));
    EXPECT_GE(bytes(1) - bytes(0), sizeof(AdaptingLif::State)) << "a neuron has a state of its own";
}

}  // namespace
}  // namespace afferent
