#include "afferent/decoders/interval_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "afferent/neurons/propagator.hpp"

namespace afferent {
namespace {

double drive(const IntervalTable::Ratios& ratios) { return ratios.phi + 1.2 * ratios.chi; }

double exact_drive(double a, double s, double g) {
    const Propagator flow = propagate(a, g * std::exp(s / a), s);
    return drive({flow.phi / flow.psi, flow.chi / flow.psi});
}

// In units of the rheobase, with a threshold of 1.2 of it. The bound is that of the header.
TEST(IntervalTable, IsWithinItsErrorOfThePropagator) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform;
    for (const double a : {0.5, 8.0, 12.0, 50.0, 1000.0}) {
        const IntervalTable table(a);
        for (int i = 0; i < 20'000; ++i) {
            const double s = std::exp(-6 + 10 * uniform(random));
            const double g = std::exp(-10 + 14 * uniform(random));
            const double exact = exact_drive(a, s, g);
            if (!std::isfinite(exact)) continue;
            EXPECT_NEAR(drive(table(s, g)), exact, 2e-4 * exact + 1e-6)
                << "a " << a << " s " << s << " g " << g;
        }
    }
}

TEST(IntervalTable, HasItsLimits) {
    const IntervalTable table(50);
    // A long interval tells the adaptation at its end, and a short one diverges as 1/s.
    EXPECT_NEAR(table(1e6, 0.5).phi, 0, 1e-12);
    EXPECT_NEAR(table(1e6, 0.5).chi, exact_drive(50, 100, 0.5) / 1.2, 1e-4);
    EXPECT_NEAR(table(1e-5, 0.5).phi * 1e-5, 1, 1e-4);
    // Without adaptation: Φ/Ψ = 1/(e^s − 1).
    for (const double s : {0.01, 0.5, 2.0, 8.0}) EXPECT_NEAR(table(s, 0).phi, 1 / std::expm1(s), 1e-4 / s);
    EXPECT_EQ(table(1, 0).chi, 0);
}

// 96 lengths by 24 adaptations, two numbers each; none for a < 8.
constexpr std::size_t bytes_of_nodes = 96 * 24 * 2 * sizeof(double);

TEST(IntervalTable, TakesMemoryForItsNodesAlone) {
    EXPECT_EQ(IntervalTable(50).bytes(), sizeof(IntervalTable) + bytes_of_nodes);
    EXPECT_EQ(IntervalTable(7.9).bytes(), sizeof(IntervalTable));
}

TEST(IntervalTable, IsSharedByAllThatDecodeNeuronsOfOneRatio) {
    auto first = IntervalTable::shared(50);
    EXPECT_EQ(first->a(), 50);
    EXPECT_EQ(IntervalTable::shared(50), first);
    EXPECT_NE(IntervalTable::shared(20), first);
    // and goes with the last of them.
    const std::weak_ptr<const IntervalTable> watched = first;
    first.reset();
    EXPECT_TRUE(watched.expired());
}

}  // namespace
}  // namespace afferent
