#include "afferent/neurons/dense_population.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "afferent/neurons/adapting_lif.hpp"
#include "afferent/neurons/models.hpp"
#include "afferent/neurons/sparse_population.hpp"
#include "afferent/runtime/event.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "tests/long_runs.hpp"

namespace afferent {
namespace {

constexpr std::size_t scans = long_runs ? 60 : 30;

// One row of drives for each scan.
using Drives = std::vector<std::vector<double>>;

Drives random_drives(unsigned seed, std::size_t count, double low_mv, double high_mv) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<> drive(low_mv, high_mv);
    Drives drives(scans, std::vector<double>(count));
    for (auto& row : drives)
        for (double& value : row) value = drive(random);
    return drives;
}

std::vector<Event> dense_events(DensePopulation& population, const Drives& drives) {
    std::vector<Event> events;
    for (const auto& row : drives)
        population.advance(row, [&](TimePoint time, Address index) { events.push_back({time, index}); });
    std::sort(events.begin(), events.end());
    return events;
}

template <class Population>
std::vector<Event> sparse_events(Population population, const Drives& drives, Duration scan_interval) {
    std::vector<Event> events;
    TimePoint time = scene_start;
    for (const auto& row : drives) {
        for (std::uint32_t i = 0; i < row.size(); ++i) population.set_drive(i, time, row[i]);
        time += scan_interval;
        population.advance(time, [&](TimePoint at, Address index) { events.push_back({at, index}); });
    }
    return events;
}

// The same spikes of the same neurons, each within 1 ns.
void expect_same(std::vector<Event> some, std::vector<Event> others) {
    ASSERT_TRUE(std::is_sorted(some.begin(), some.end()));
    ASSERT_EQ(some.size(), others.size());
    const auto by_neuron = [](const Event& a, const Event& b) {
        return std::pair(a.address, a.time) < std::pair(b.address, b.time);
    };
    std::sort(some.begin(), some.end(), by_neuron);
    std::sort(others.begin(), others.end(), by_neuron);
    for (std::size_t i = 0; i < some.size(); ++i) {
        ASSERT_EQ(some[i].address, others[i].address) << i;
        ASSERT_LE(std::chrono::abs(some[i].time - others[i].time), Duration(1)) << i;
    }
}

void expect_dense_is_sparse(const LifParameters& parameters, Duration scan_interval, double high_mv,
                            unsigned seed) {
    constexpr std::size_t count = 203;  // no multiple of any vector
    const Drives drives = random_drives(seed, count, -5, high_mv);
    DensePopulation dense(parameters, count, scan_interval);
    const auto events = dense_events(dense, drives);
    EXPECT_GT(events.size(), count);
    std::visit(
        [&]<class Model>(const Model& model) {
            expect_same(events, sparse_events(SparsePopulation<Model>(model, count), drives, scan_interval));
        },
        smallest_model(parameters));
    dense.reset();
    EXPECT_EQ(dense_events(dense, drives), events);
}

TEST(DensePopulation, GivesTheEventsOfTheSparseForm) {
    expect_dense_is_sparse({}, 5ms, 60, 1);
    expect_dense_is_sparse({.delta_g = 0.6}, 5ms, 90, 2);
    expect_dense_is_sparse({.delta_g = 5}, 5ms, 300, 3);
    expect_dense_is_sparse({.tau_g_ms = 1e5, .delta_g = 1}, 5ms, 300, 4);
    expect_dense_is_sparse({.tau_m_ms = 20, .tau_g_ms = 30}, 10ms, 90, 5);
    expect_dense_is_sparse({.tau_m_ms = 10, .tau_g_ms = 6}, 5ms, 90, 6);
    expect_dense_is_sparse({.v_r_mv = -75, .e_k_mv = -70}, 1ms, 200, 7);
}

// Crossings wait for those of later tiles: that moves nothing.
TEST(DensePopulation, GivesTheEventsOfItsPartsBySweepsOfTheirOwn) {
    const auto expect_parts = [](const LifParameters& parameters, double high_mv, unsigned seed) {
        constexpr std::array<std::size_t, 3> sizes{603, 97, 450};
        constexpr std::size_t count = 1150;
        Drives drives = random_drives(seed, count, -5, high_mv);
        drives.resize(10);
        DensePopulation whole(parameters, count, 5ms);
        std::vector<Event> parts;
        std::ptrdiff_t begin = 0;
        for (const std::size_t size : sizes) {
            Drives own;
            for (const auto& row : drives)
                own.emplace_back(row.begin() + begin,
                                 row.begin() + begin + static_cast<std::ptrdiff_t>(size));
            DensePopulation part(parameters, size, 5ms);
            for (const Event& event : dense_events(part, own))
                parts.push_back({event.time, event.address + static_cast<Address>(begin)});
            begin += static_cast<std::ptrdiff_t>(size);
        }
        std::sort(parts.begin(), parts.end());
        EXPECT_GT(parts.size(), count);
        EXPECT_EQ(dense_events(whole, drives), parts);
    };
    for (const double refractory_ms : {0.0, 0.3})
        for (const double delta_g : {0.0, 0.3}) {
            SCOPED_TRACE(std::to_string(refractory_ms) + ", " + std::to_string(delta_g));
            // Few neurons fire twice in a scan interval; nearly all do, several times.
            for (const double high_mv : {60.0, 600.0})
                expect_parts({.delta_g = delta_g, .refractory_ms = refractory_ms}, high_mv, 1);
            expect_parts({.tau_g_ms = 6, .delta_g = delta_g, .refractory_ms = refractory_ms}, 90, 2);
        }
}

TEST(DensePopulation, GivesTheEventsOfTheSparseFormWithEveryInstructionSet) {
    for (std::int64_t targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
        const std::int64_t target = targets & -targets;
        hwy::SetSupportedTargetsForTest(target);
        SCOPED_TRACE(hwy::TargetName(target));
        expect_dense_is_sparse({.delta_g = 0.3}, 5ms, 90, 8);
        expect_dense_is_sparse({.delta_g = 0}, 5ms, 60, 9);
        hwy::SetSupportedTargetsForTest(0);
    }
}

TEST(DensePopulation, GivesTheEventsOfTheSparseFormWithoutAdaptation) {
    expect_dense_is_sparse({.delta_g = 0}, 5ms, 60, 1);
    expect_dense_is_sparse({.tau_m_ms = 1, .delta_g = 0}, 5ms, 60, 2);
}

// Shorter than a scan interval, as long, longer, and almost none.
TEST(DensePopulation, GivesTheEventsOfTheSparseFormWithARefractoryPeriod) {
    for (const double refractory_ms : {0.001, 0.3, 2.0, 5.0, 12.5}) {
        SCOPED_TRACE(refractory_ms);
        expect_dense_is_sparse({.delta_g = 0, .refractory_ms = refractory_ms}, 5ms, 120, 1);
        expect_dense_is_sparse({.delta_g = 0.3, .refractory_ms = refractory_ms}, 5ms, 200, 2);
        expect_dense_is_sparse({.delta_g = 5, .refractory_ms = refractory_ms}, 5ms, 900, 3);
        expect_dense_is_sparse({.tau_g_ms = 30, .delta_g = 0.3, .refractory_ms = refractory_ms}, 20ms, 300,
                               4);
    }
    expect_dense_is_sparse({.delta_g = 0, .refractory_ms = 0.4}, 5ms, 3000, 5);
    expect_dense_is_sparse({.delta_g = 0.01, .refractory_ms = 0.4}, 5ms, 3000, 6);
}

// In between scans whose times are rounded.
TEST(DensePopulation, TellsTimesThatAreNotRounded) {
    constexpr std::size_t count = 20;
    const Drives drives = random_drives(8, count, 0, 120);
    DensePopulation rounds(LifParameters{}, count, 5ms), both(LifParameters{}, count, 5ms);
    std::size_t spikes = 0;
    for (std::size_t scan = 0; scan < scans; ++scan) {
        std::vector<Event> rounded, other;
        rounds.advance(drives[scan], [&](TimePoint time, Address index) {
            rounded.push_back({time, index});
        });
        const TimePoint begin = both.time();
        if (scan % 2 == 0)
            both.advance(drives[scan], [&](TimePoint time, Address index) {
                other.push_back({time, index});
            });
        else
            both.advance_unrounded(drives[scan], [&](Address index, Interval span) {
                other.push_back({begin + Duration(std::llround(std::ceil(span.count()))), index});
            });
        EXPECT_EQ(other, rounded) << scan;
        spikes += rounded.size();
    }
    EXPECT_GT(spikes, count);
}

TEST(DensePopulation, SolvesManySpikesOfANeuronInAScanInterval) {
    expect_dense_is_sparse({.delta_g = 0.01}, 5ms, 3000, 1);
    expect_dense_is_sparse({.delta_g = 0.3}, 5ms, 3000, 2);
}

// Drives at which the membrane only just reaches the threshold, and levels that repeat.
TEST(DensePopulation, LosesNoGrazingSpike) {
    const LifParameters parameters{.delta_g = 0.3};
    Drives drives = random_drives(1, 203, 0, 1);
    for (auto& row : drives)
        for (double& value : row)
            value = parameters.rheobase_mv() * (1 + std::pow(10, -16 * value) * (value < 0.9));
    DensePopulation dense(parameters, 203, 30ms);
    expect_same(dense_events(dense, drives),
                sparse_events(SparsePopulation<AdaptingLif>(AdaptingLif(parameters), 203), drives, 30ms));
}

// In thresholds, in what a spike adds to g, or in both.
TEST(DensePopulation, TakesNeuronsThatDiffer) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<> unit;
    for (const auto& [thresholds, jumps] : {std::pair(true, true), {true, false}, {false, true}}) {
        std::vector<LifParameters> parameters(203);
        for (LifParameters& each : parameters) {
            if (thresholds) each.v_th_mv = -55 + 10 * unit(random);
            if (jumps) each.delta_g = unit(random) < 0.2 ? 0 : unit(random);
        }
        const Drives drives = random_drives(2, parameters.size(), 0, 100);
        std::vector<double> phases(parameters.size());
        for (double& phase : phases) phase = unit(random);
        for (const Phases& each : {Phases(), Phases([&](std::uint32_t i) { return phases[i]; })}) {
            DensePopulation dense(parameters, 5ms, {}, each);
            using Sparse = SparsePopulation<AdaptingLif, Individual<AdaptingLif>>;
            const auto events = dense_events(dense, drives);
            expect_same(events,
                        sparse_events(Sparse(Individual<AdaptingLif>(parameters, each), parameters.size()),
                                      drives, 5ms));
            dense.reset();
            EXPECT_EQ(dense_events(dense, drives), events);
        }
    }
}

TEST(DensePopulation, SaysWhatItRefusesAndWhy) {
    EXPECT_FALSE(DensePopulation::refusal({}, 5ms));
    EXPECT_EQ(DensePopulation::refusal(FixedPointParameters{}, 5ms).value_or(""),
              "neuron must be lif for the dense form, which evaluates its exact solution, is fixed_point");
    EXPECT_TRUE(DensePopulation::refusal({}, 0ms));
    EXPECT_TRUE(DensePopulation::pays({}, 5ms));
    EXPECT_FALSE(DensePopulation::pays({.tau_g_ms = 0.01, .delta_g = 30}, 5ms));
    EXPECT_EQ(DensePopulation::refusal({}, 4001ms).value_or(""),
              "scan_interval_ms must be at most 4000 for the dense form, is 4001");
    EXPECT_THROW(DensePopulation({}, 10, 0ms), ParameterError);
    EXPECT_THROW(DensePopulation(std::vector<LifParameters>(), 5ms), ParameterError);
}

// Where no series holds over the interval, or no polynomial, or neither.
TEST(DensePopulation, TakesStiffNeurons) {
    for (const LifParameters& parameters :
         {LifParameters{.tau_g_ms = 0.01, .delta_g = 30}, LifParameters{.tau_g_ms = 1, .delta_g = 0.5},
          LifParameters{.tau_g_ms = 1e5, .delta_g = 30}, LifParameters{.tau_m_ms = 0.2, .tau_g_ms = 20},
          LifParameters{.tau_m_ms = 0.05, .tau_g_ms = 20, .delta_g = 3},
          LifParameters{.tau_g_ms = 1e-8, .delta_g = 1}, LifParameters{.tau_g_ms = 50, .delta_g = 1000},
          LifParameters{.tau_g_ms = 0.1, .delta_g = 1e100}}) {
        SCOPED_TRACE(std::to_string(parameters.tau_m_ms) + " " + std::to_string(parameters.tau_g_ms) + " " +
                     std::to_string(parameters.delta_g));
        const double strong = parameters.delta_g < 30 ? 40 : parameters.tau_g_ms < 1 ? 200 : 3000;
        expect_dense_is_sparse(parameters, 5ms, strong, 1);
        if (parameters.tau_m_ms < 10 || parameters.delta_g < 1) continue;
        LifParameters resting = parameters;
        resting.refractory_ms = 1.5;
        DensePopulation dense(resting, 203, 5ms);
        const Drives drives = random_drives(7, 203, -5, strong);
        using Neuron = Refractory<AdaptingLif>;
        expect_same(dense_events(dense, drives),
                    sparse_events(SparsePopulation<Neuron>(Neuron(resting), 203), drives, 5ms));
    }
}

TEST(DensePopulation, TakesNeuronsOfSeveralTimeConstants) {
    std::vector<LifParameters> parameters(203);
    for (std::size_t i = 0; i < parameters.size(); ++i) {
        if (i % 3 == 0) parameters[i].tau_m_ms = 4;
        if (i % 5 == 0) parameters[i].tau_g_ms = 0.02;
        if (i % 7 == 0) parameters[i].delta_g = i % 2 == 0 ? 0 : 200;
        parameters[i].v_th_mv += 0.01 * static_cast<double>(i);
    }
    const Drives drives = random_drives(4, parameters.size(), 0, 100);
    const Phases phases = [](std::uint32_t) { return 0.3; };
    DensePopulation dense(parameters, 5ms, {}, phases);
    using Sparse = SparsePopulation<AdaptingLif, Individual<AdaptingLif>>;
    const auto expected =
        sparse_events(Sparse(Individual<AdaptingLif>(parameters, phases), parameters.size()), drives, 5ms);
    EXPECT_GT(expected.size(), 1000U);
    expect_same(dense_events(dense, drives), expected);

    // States have the population's own indices, there and back.
    dense.reset();
    DensePopulation other(parameters, 5ms);
    std::vector<Event> events;
    for (std::size_t k = 0; k < drives.size(); ++k) {
        DensePopulation& population = k < drives.size() / 2 ? dense : other;
        if (k == drives.size() / 2) {
            std::vector<LifState> states(parameters.size());
            dense.for_each_state([&](std::uint32_t i, const LifState& state) { states[i] = state; });
            other.restore(dense.time(), [&](std::uint32_t i) { return states[i]; });
        }
        population.advance(drives[k], [&](TimePoint time, Address i) { events.push_back({time, i}); });
    }
    std::sort(events.begin(), events.end());
    expect_same(events, expected);

    dense.reset();
    std::vector<double> seen(parameters.size());
    dense.for_each_state([&](std::uint32_t i, const LifState& state) { seen[i] = state.gap_mv; });
    for (std::size_t i = 0; i < seen.size(); ++i)
        EXPECT_DOUBLE_EQ(seen[i], 0.7 * (parameters[i].v_th_mv - parameters[i].v_r_mv));
}

// Adapting: v, g and the drive are three doubles; what else a neuron has in its refractory period is kept
// only while it lasts.
TEST(DensePopulation, TakesFewBytes) {
    const auto bytes = [](const LifParameters& parameters) {
        return static_cast<double>(DensePopulation(parameters, 10'000, 5ms).bytes()) / 10'000;
    };
    EXPECT_LT(bytes({}), 17);
    EXPECT_LT(bytes({.delta_g = 0}), 9);
    EXPECT_LT(bytes({.refractory_ms = 2}), 22);
}

// So that a sweep over many populations is a few long streams.
TEST(DensePopulation, LiesBehindThoseThatShareItsScratchMemory) {
    const auto scratch = make_dense_scratch(2000);
    DensePopulation first({}, 1000, 5ms, {}, {}, scratch);
    DensePopulation second({}, 999, 5ms, {}, {}, scratch);
    DensePopulation beyond({}, 100, 5ms, {}, {}, scratch);
    const std::span<double> of_first = first.take_drives();
    EXPECT_EQ(second.take_drives().data(), of_first.data() + of_first.size());
    // There is no more room, and it works all the same.
    const std::span<double> drives_mv = beyond.take_drives();
    std::ranges::fill(drives_mv, 30.0);
    DensePopulation alone({}, 100, 5ms);
    std::vector<Event> events;
    std::vector<Event> expected;
    for (int i = 0; i < 20; ++i) {
        beyond.advance(drives_mv, [&](TimePoint time, std::uint32_t k) { events.push_back({time, k}); });
        alone.advance(drives_mv, [&](TimePoint time, std::uint32_t k) { expected.push_back({time, k}); });
    }
    EXPECT_GT(expected.size(), 100U);
    EXPECT_EQ(events, expected);
}

TEST(DensePopulation, KnowsItsSizeBeforeItIsBuilt) {
    constexpr std::size_t count = 1000;
    for (const LifParameters& parameters :
         {LifParameters{}, LifParameters{.delta_g = 0}, LifParameters{.refractory_ms = 2}}) {
        EXPECT_EQ(DensePopulation::size_of(parameters, count),
                  DensePopulation(parameters, count, 5ms).bytes());
    }
    std::vector<LifParameters> parameters(count);
    const auto expect_known = [&] {
        EXPECT_EQ(DensePopulation::size_of(parameters, 5ms), DensePopulation(parameters, 5ms).bytes());
    };
    expect_known();
    parameters.back().delta_g *= 2;
    expect_known();
    parameters.front().tau_m_ms *= 2;
    expect_known();
    for (LifParameters& each : parameters) each.delta_g = 0;
    expect_known();
}

// Between any two scans, from one form to the other and back.
TEST(DensePopulation, GoesOnFromTheStatesOfTheSparseForm) {
    const auto expect_handed_over = []<class N>(const N& neuron, const LifParameters& parameters) {
        constexpr std::size_t count = 203;
        const Drives drives = random_drives(11, count, -5, 120);
        std::vector<Event> events;
        const auto sink = [&](TimePoint time, Address index) { events.push_back({time, index}); };
        SparsePopulation<N> sparse(neuron, count);
        DensePopulation dense(parameters, count, 5ms);
        TimePoint time = scene_start;
        bool is_dense = false;
        for (std::size_t scan = 0; scan < scans; ++scan, time += 5ms) {
            if (is_dense != (scan % 6 >= 3)) {
                is_dense = !is_dense;
                if (is_dense)
                    dense.restore(time, [&](Address i) { return to_lif_state(sparse.state(i, time)); });
                else
                    dense.for_each_state([&](Address i, const LifState& state) {
                        sparse.restore(i, time, from_lif_state<typename N::State>(state), 0);
                    });
            }
            if (is_dense) {
                dense.advance(drives[scan], sink);
            } else {
                for (Address i = 0; i < count; ++i) sparse.set_drive(i, time, drives[scan][i]);
                sparse.advance(time + 5ms, sink);
            }
        }
        std::sort(events.begin(), events.end());
        EXPECT_GT(events.size(), count);
        expect_same(events, sparse_events(SparsePopulation<N>(neuron, count), drives, 5ms));
    };
    for (const double delta_g : {0.0, 0.3})
        for (const double refractory_ms : {0.0, 2.0, 12.0}) {
            SCOPED_TRACE(std::to_string(delta_g) + ", " + std::to_string(refractory_ms));
            const LifParameters parameters{.delta_g = delta_g, .refractory_ms = refractory_ms};
            std::visit([&](const auto& neuron) { expect_handed_over(neuron, parameters); },
                       smallest_neuron(parameters));
        }
}

TEST(DensePopulation, StopsANeuronThatStorms) {
    for (const std::size_t count : {20, 1750})
        for (const double delta_g : {0.0, 0.06}) {
            DensePopulation population(LifParameters{.delta_g = delta_g}, count, 5ms,
                                       {.spikes = 100, .window = 5ms});
            std::vector<double> drives(count, 30.0);
            drives[11] = 1e9;
            std::size_t spikes = 0;
            population.advance(drives, [&](TimePoint, Address index) { spikes += index == 11; });
            ASSERT_TRUE(population.storm());
            EXPECT_EQ(population.storm()->index, 11U);
            // A neuron that is also computed by itself is counted there once more.
            EXPECT_GE(spikes, 100U);
            EXPECT_LE(spikes, 200U);
            population.reset();
            EXPECT_FALSE(population.storm());
        }
}

TEST(DensePopulation, MayFireAsOftenAsTheLimitAndNotOnceWhereItIsNone) {
    for (const std::uint32_t most : {0, 1}) {
        DensePopulation population(LifParameters{}, 700, 5ms, {.spikes = most, .window = 5ms});
        std::size_t spikes = 0;
        population.advance(std::vector<double>(700, 40.0), [&](TimePoint, Address) { ++spikes; });
        EXPECT_EQ(population.storm().has_value(), most == 0);
        EXPECT_EQ(spikes, 700U * most);
    }
}

}  // namespace
}  // namespace afferent
