#include "afferent/neurons/adapting_lif.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "bench/reference.hpp"
#include "tests/neurons/cases.hpp"

namespace afferent {
namespace {

using reference::Real;

// The error that the runtime promises.
double tolerance_s(double span_s) { return std::max(1e-9, 1e-12 * span_s); }

struct Case {
    LifParameters parameters;
    double gap_mv;
    double g;
    double drive_mv;
};

double next_spike_error_s(const Case& c, double* span_s) {
    const AdaptingLif neuron(c.parameters);
    const Interval span = neuron.next_spike({c.gap_mv, c.g}, c.drive_mv);
    const auto truth =
        reference::Neuron(c.parameters)
            .next_spike_s({c.gap_mv, c.g}, c.drive_mv, span == never ? 0 : span.count() * 1e-9);
    if (!truth) {
        *span_s = span == never ? 0 : -1;
        return span == never ? 0 : 1;
    }
    *span_s = static_cast<double>(*truth);
    return static_cast<double>(abs(Real(span.count()) / 1'000'000'000 - *truth));
}

TEST(AdaptingLif, PredictsTheSpikeOverTheWholeRange) {
    std::mt19937_64 random(1);
    int checked = 0;
    for (int i = 0; i < cases; ++i) {
        Case c;
        c.parameters.tau_m_ms = log_uniform(random, 0.1, 1000);
        c.parameters.tau_g_ms = c.parameters.tau_m_ms * log_uniform(random, 1e-8, 1e8);
        c.gap_mv = log_uniform(random, 1e-6, 1e3);
        c.g = i % 5 == 0 ? 0 : log_uniform(random, 1e-6, 1e6);
        const double rheobase = c.parameters.rheobase_mv();
        c.drive_mv = rheobase + rheobase * log_uniform(random, 1e-15, 1e7);
        double span_s = 0;
        const double error_s = next_spike_error_s(c, &span_s);
        ++checked;
        EXPECT_LE(error_s, tolerance_s(span_s))
            << i << " tau_m " << c.parameters.tau_m_ms << " a "
            << c.parameters.tau_g_ms / c.parameters.tau_m_ms << " gap " << c.gap_mv << " g " << c.g
            << " drive " << c.drive_mv << " excess " << c.drive_mv - rheobase << " span " << span_s;
    }
    EXPECT_EQ(checked, cases);
}

// With a conductance that does not decay the membrane may never reach the threshold: no time then follows
// from the closed form.
TEST(AdaptingLif, BoundsASpikeFromBelowHoweverMuchItHasAdapted) {
    for (const double g : {0.5, 2.0, 10.0, 1e3, 1e6}) {
        const AdaptingLif neuron(AdaptingLif::Parameters{.tau_m_ms = 10, .tau_g_ms = 500, .delta_g = 0.1});
        AdaptingLif::State state = neuron.rest();
        state.g = g;
        for (const double drive_mv : {20.0, 40.0, 100.0, 400.0}) {
            const Interval bound = neuron.earliest_spike(state, drive_mv);
            EXPECT_GE(bound.count(), 0) << g << ' ' << drive_mv;
            EXPECT_LE(bound.count(), neuron.next_spike(state, drive_mv).count() * (1 + 1e-12));
        }
    }
}

// Without conductance the closed form is the spike itself.
TEST(AdaptingLif, BoundsASpikeClosely) {
    const AdaptingLif neuron(AdaptingLif::Parameters{.tau_m_ms = 10, .tau_g_ms = 500, .delta_g = 0.1});
    const AdaptingLif::State state = neuron.rest();
    for (const double drive_mv : {24.0, 30.0, 60.0, 600.0}) {
        const double exact_ns = 10e6 * std::log1p(15 / (drive_mv - 15));
        EXPECT_NEAR(neuron.earliest_spike(state, drive_mv).count() / exact_ns, 0.9975, 0.0025) << drive_mv;
    }
}

TEST(AdaptingLif, BoundsASpikeWhereSquaresLeaveTheRangeOfADouble) {
    for (const double mv : {1e-300, 1e-170, 1e150, 1e290}) {
        for (const double tau_g_ms : {5.0, 500.0}) {
            const AdaptingLif neuron(AdaptingLif::Parameters{.tau_m_ms = 10,
                                                             .tau_g_ms = tau_g_ms,
                                                             .v_r_mv = 0,
                                                             .v_th_mv = 15 * mv,
                                                             .e_k_mv = -5 * mv,
                                                             .delta_g = 0.1});
            AdaptingLif::State state = neuron.rest();
            state.g = 0.01;
            const Interval bound = neuron.earliest_spike(state, 40 * mv);
            EXPECT_GE(bound.count(), 0) << mv;
            EXPECT_LE(bound.count(), neuron.next_spike(state, 40 * mv).count()) << mv;
        }
    }
}

}  // namespace
}  // namespace afferent
