#include "afferent/neurons/propagator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "bench/reference.hpp"
#include "tests/neurons/cases.hpp"

namespace afferent {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

// z under a drive, from the reference: with one of z₀, c and W at 1 and the others at 0 it is Φ, −Ψ or X.
reference::Real reference_gap(double a, double g, double s, double gap, double excess, double reversal) {
    LifParameters parameters{.tau_m_ms = 1, .v_r_mv = -1, .v_th_mv = 0};
    parameters.tau_g_ms = a;
    parameters.e_k_mv = -reversal;
    const reference::State end =
        reference::Neuron(parameters).advance({gap, g}, 1 + excess, reference::Real(s) / 1000);
    return end.gap_mv;
}

TEST(Propagator, AgreesWithFiftyDigitsOverTheWholeRange) {
    std::mt19937_64 random(1);
    for (int i = 0; i < cases; ++i) {
        const double a = log_uniform(random, 1e-8, 1e8);
        const double g = i % 7 == 0 ? 0 : log_uniform(random, 1e-6, 1e6);
        const double s = log_uniform(random, 1e-7, 1e8);
        const Propagator flow = propagate(a, g, s);
        // A few operations on each; e^(−s/a) also carries its exponent's last digit.
        const double tolerance = 30 * epsilon;
        const auto psi =
            static_cast<double>(reference_gap(a, g, s, 0, 0, 1) - reference_gap(a, g, s, 0, 1, 1));
        const auto chi = static_cast<double>(reference_gap(a, g, s, 0, 0, 1));
        // What the reference leaves out.
        constexpr double unseen = 1e-30;
        EXPECT_NEAR(flow.psi, psi, tolerance * psi + unseen) << a << ' ' << g << ' ' << s;
        EXPECT_NEAR(flow.chi, chi, tolerance * (1 + s / a) * chi + unseen) << a << ' ' << g << ' ' << s;
        EXPECT_NEAR(flow.phi + flow.psi + flow.chi, 1, 8 * epsilon) << a << ' ' << g << ' ' << s;
    }
}

// Without conductance, and with one that does not decay, there are closed forms.
TEST(Propagator, MeetsItsClosedForms) {
    for (const double s : {1e-7, 1e-3, 0.5, 1.0, 30.0, 1e8}) {
        for (const double a : {1e-8, 0.5, 1.0, 2.0, 1e8}) {
            const Propagator still = propagate(a, 0, s);
            EXPECT_NEAR(still.phi, std::exp(-s), 4 * epsilon * std::exp(-s) * (1 + s));
            EXPECT_NEAR(still.psi, -std::expm1(-s), 4 * epsilon);
            EXPECT_EQ(still.chi, 0);
        }
        for (const double g : {1e-3, 1.0, 1e3}) {
            if (s > 1) continue;
            const double rate = 1 + g;
            const Propagator constant = propagate(1e18, g, s);
            EXPECT_NEAR(constant.psi, -std::expm1(-rate * s) / rate, 1e-14 * constant.psi) << g << ' ' << s;
        }
    }
}

// The expansion has terms whose denominators vanish where a is a whole number; nothing may show there.
TEST(Propagator, IsSmoothWhereAIsAWholeNumber) {
    for (const double whole : {1.0, 2.0, 3.0, 7.0}) {
        for (const double g : {1e-4, 0.3, 5.0}) {
            const Propagator at = propagate(whole, g, 1.3);
            for (const double side : {-1.0, 1.0}) {
                const Propagator near = propagate(whole * (1 + side * 1e-13), g, 1.3);
                EXPECT_NEAR(near.psi, at.psi, 1e-12);
                EXPECT_NEAR(near.chi, at.chi, 1e-12);
            }
        }
    }
}

TEST(Propagator, ComposesOneStepFromMany) {
    std::mt19937_64 random(2);
    for (int i = 0; i < 200; ++i) {
        const double a = log_uniform(random, 1e-4, 1e4);
        const double g = log_uniform(random, 1e-3, 1e3);
        const double s = log_uniform(random, 1e-4, 10);
        const Propagator whole = propagate(a, g, s);
        double psi = 0;
        double at = g;
        for (int k = 0; k < 7; ++k) {
            const Propagator part = propagate(a, at, s / 7);
            psi = psi * part.phi + part.psi;
            at = part.g;
        }
        EXPECT_NEAR(psi, whole.psi, 1e-13 * whole.psi) << a << ' ' << g << ' ' << s;
    }
}

}  // namespace
}  // namespace afferent
