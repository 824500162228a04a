#include "afferent/decoders/interval_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>

#include "afferent/neurons/propagator.hpp"

namespace afferent {
namespace {

// After `longest` membrane times the beginning of an interval no longer matters.
constexpr int lengths = 96;
constexpr int adaptations = 24;
constexpr double longest = 60;
constexpr double strongest = 32;
constexpr double least_a = 8;

constexpr double length_step = longest / (1 + longest) / (lengths - 1);
constexpr double adaptation_step = strongest / (1 + strongest) / (adaptations - 1);
// Multiplied by, as a division takes longer.
constexpr double lengths_per_unit = 1 / length_step;
constexpr double adaptations_per_unit = 1 / adaptation_step;

IntervalTable::Ratios exactly(double a, double s, double g) noexcept {
    const Propagator flow = propagate(a, g * std::exp(s / a), s);
    return {flow.phi / flow.psi, flow.chi / flow.psi};
}

// The four nodes about a place, and their weights: Lagrange's cubic.
struct Cubic {
    int first;
    std::array<double, 4> weight;
    Cubic(double place, int nodes) noexcept : first(std::clamp(static_cast<int>(place) - 1, 0, nodes - 4)) {
        const double x = place - first;
        const double x1 = x - 1;
        const double x2 = x - 2;
        const double x3 = x - 3;
        weight = {x1 * x2 * x3 * (-1.0 / 6), x * x2 * x3 * 0.5, x * x1 * x3 * -0.5, x * x1 * x2 * (1.0 / 6)};
    }
};

}  // namespace

std::shared_ptr<const IntervalTable> IntervalTable::shared(double a) {
    static std::mutex mutex;
    static std::vector<std::weak_ptr<const IntervalTable>> tables;
    static std::shared_ptr<const IntervalTable> last;
    const std::lock_guard lock(mutex);
    std::erase_if(tables, [](const auto& table) { return table.expired(); });
    for (const auto& known : tables)
        if (const auto table = known.lock(); table && table->a() == a) return last = table;
    last = std::make_shared<const IntervalTable>(a);
    tables.push_back(last);
    return last;
}

IntervalTable::IntervalTable(double a) : a_(a) {
    if (!(a >= least_a)) return;
    nodes_.reserve(std::size_t{lengths} * std::size_t{adaptations});
    for (int j = 0; j < adaptations; ++j)
        for (int i = 0; i < lengths; ++i) {
            // At the edges of the table, the limits: taken from just inside.
            const double y = std::max(j * adaptation_step, 1e-9);
            const double x = std::max(i * length_step, 1e-9);
            const double g = y / (1 - y);
            const double s = x / (1 - x) / (1 + g);
            const Ratios ratios = exactly(a, s, g);
            nodes_.push_back({s * ratios.phi, ratios.chi / g});
        }
}

IntervalTable::Ratios IntervalTable::operator()(double s, double g) const noexcept {
    if (nodes_.empty() || g > strongest) return exactly(a_, s, g);
    const double sigma = std::min((1 + g) * s, longest);
    const Cubic length(sigma / (1 + sigma) * lengths_per_unit, lengths);
    const Cubic adaptation(g / (1 + g) * adaptations_per_unit, adaptations);
    Ratios sum{};
    for (int j = 0; j < 4; ++j) {
        const Ratios* row = &nodes_[static_cast<std::size_t>(adaptation.first + j) * std::size_t{lengths} +
                                    static_cast<std::size_t>(length.first)];
        Ratios along{};
        for (std::size_t i = 0; i < 4; ++i) {
            along.phi += length.weight[i] * row[i].phi;
            along.chi += length.weight[i] * row[i].chi;
        }
        sum.phi += adaptation.weight[static_cast<std::size_t>(j)] * along.phi;
        sum.chi += adaptation.weight[static_cast<std::size_t>(j)] * along.chi;
    }
    return {sum.phi / s, sum.chi * g};
}

}  // namespace afferent
