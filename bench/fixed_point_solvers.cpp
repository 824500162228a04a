// The neuron of a chip: the same equations in integers of 8 to 24 bits, on a tick.
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <variant>
#include <vector>

#include "afferent/neurons/fixed_point.hpp"
#include "afferent/neurons/sparse_population.hpp"
#include "bench/solver.hpp"
#include "bench/sparse_run.hpp"

namespace afferent::bench {
namespace {

struct Arithmetic {
    std::string_view name;
    std::uint32_t bits;
    Rounding rounding;
};

constexpr std::array arithmetics{
    Arithmetic{"fixed-8", 8, Rounding::half_even},
    Arithmetic{"fixed-12", 12, Rounding::half_even},
    Arithmetic{"fixed-16", 16, Rounding::half_even},
    Arithmetic{"fixed-24", 24, Rounding::half_even},
    Arithmetic{"fixed-8-truncated", 8, Rounding::truncation},
    Arithmetic{"fixed-12-truncated", 12, Rounding::truncation},
    Arithmetic{"fixed-16-truncated", 16, Rounding::truncation},
    Arithmetic{"fixed-24-truncated", 24, Rounding::truncation},
};

// Multipliers of fewer than 16 bits cannot express the decay of a usual adaptation on a tick of 0.1 ms.
constexpr std::uint32_t least_decay_bits = 16;

class FixedPointSolver final : public Solver {
  public:
    FixedPointSolver(const Arithmetic& arithmetic, double tick_ms)
        : arithmetic_(arithmetic),
          tick_us_(static_cast<std::uint32_t>(std::lround(std::clamp(1000 * tick_ms, 0.0, 1e9)))) {}

    void prepare(const Workload& workload) override {
        try {
            check_drives(workload);
            std::vector<FixedPointParameters> parameters;
            for (const LifParameters& lif : workload.parameters)
                parameters.push_back({.lif = lif,
                                      .tick_us = tick_us_,
                                      .state_bits = arithmetic_.bits,
                                      .decay_bits = std::max(least_decay_bits, arithmetic_.bits),
                                      .rounding = arithmetic_.rounding});
            const SpikeLimit limit{.spikes = spike_limit(workload), .window = 1h};
            if (parameters.size() > 1)
                population_.emplace<Differing>(Individual<FixedPointLif>(parameters), workload.neurons,
                                               limit);
            else
                population_.emplace<Alikes>(FixedPointLif(parameters.front()), workload.neurons, limit);
        } catch (const ParameterError& error) {
            throw Unserved(error.what());
        }
    }

    void run(const Workload& workload, Trains& trains) override {
        carry_out(workload, [&](TimePoint time, std::uint32_t i, Interval rest) {
            note(workload, trains, i, {time, rest});
        });
    }
    std::size_t count(const Workload& workload) override {
        std::size_t spikes = 0;
        carry_out(workload, [&](TimePoint, std::uint32_t) { ++spikes; });
        return spikes;
    }

  private:
    using Alikes = SparsePopulation<FixedPointLif>;
    using Differing = SparsePopulation<FixedPointLif, Individual<FixedPointLif>>;

    template <class Sink>
    void carry_out(const Workload& workload, Sink&& sink) {
        if (auto* alikes = std::get_if<Alikes>(&population_)) run_sparse(*alikes, workload, sink);
        if (auto* differing = std::get_if<Differing>(&population_)) run_sparse(*differing, workload, sink);
    }

    Arithmetic arithmetic_;
    std::uint32_t tick_us_;
    std::variant<std::monostate, Alikes, Differing> population_;
};

}  // namespace

std::vector<std::string> fixed_point_solver_names() {
    std::vector<std::string> names;
    for (const Arithmetic& arithmetic : arithmetics) names.emplace_back(arithmetic.name);
    return names;
}

std::unique_ptr<Solver> make_fixed_point_solver(const SolverSpec& spec) {
    constexpr double usual_tick_ms = 0.1;
    for (const Arithmetic& arithmetic : arithmetics)
        if (spec.name == arithmetic.name)
            return std::make_unique<FixedPointSolver>(arithmetic,
                                                      spec.setting > 0 ? spec.setting : usual_tick_ms);
    return nullptr;
}

}  // namespace afferent::bench
