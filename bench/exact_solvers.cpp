// The exact neuron in its sparse and its dense form, as the runtime uses them.
#include <algorithm>
#include <optional>
#include <variant>

#include "afferent/neurons/dense_population.hpp"
#include "afferent/neurons/models.hpp"
#include "afferent/neurons/sparse_population.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "bench/solver.hpp"
#include "bench/sparse_run.hpp"

namespace afferent::bench {
namespace {

class SparseSolver final : public Solver {
  public:
    void prepare(const Workload& workload) override {
        try {
            check_drives(workload);
            const SpikeLimit limit{.spikes = spike_limit(workload), .window = 1h};
            if (workload.parameters.size() > 1) {
                population_.emplace<SparsePopulation<AdaptingLif, Individual<AdaptingLif>>>(
                    Individual<AdaptingLif>(workload.parameters), workload.neurons, limit);
            } else {
                std::visit(
                    [&]<Neuron N>(const N& neuron) {
                        population_.emplace<SparsePopulation<N>>(neuron, workload.neurons, limit);
                    },
                    smallest_neuron(workload.parameters.front()));
            }
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
    template <class Sink>
    void carry_out(const Workload& workload, Sink&& sink) {
        std::visit(
            [&]<class P>(P& population) {
                if constexpr (!std::is_same_v<P, std::monostate>) run_sparse(population, workload, sink);
            },
            population_);
    }

    std::variant<std::monostate, SparsePopulation<Lif>, SparsePopulation<Refractory<Lif>>,
                 SparsePopulation<AdaptingLif>, SparsePopulation<Refractory<AdaptingLif>>,
                 SparsePopulation<AdaptingLif, Individual<AdaptingLif>>>
        population_;
};

class DenseSolver final : public Solver {
  public:
    // On the workload's own clock. If it has none, on the longest interval that every row is a multiple of
    // and that the dense form takes.
    void prepare(const Workload& workload) override {
        try {
            check_drives(workload);
            const Duration longest = workload.common_interval();
            std::optional<std::string> refusal;
            const bool clocked =
                workload.rows() > 1 &&
                longest * static_cast<Duration::rep>(workload.rows()) == workload.until - scene_start;
            for (Duration::rep parts = 1; parts <= (clocked ? 1 : 10'000); ++parts) {
                scan_interval_ = longest / parts;
                if (longest % parts != Duration(0)) continue;
                refusal = DensePopulation::refusal(hardest(workload), scan_interval_);
                if (!refusal) break;
            }
            if (refusal) throw Unserved(*refusal);
            const auto scans = static_cast<double>((workload.until - scene_start) / scan_interval_);
            if (scans * static_cast<double>(workload.neurons) > workload.most_steps)
                throw Unserved("takes too many scans");
            const SpikeLimit limit{.spikes = 1000, .window = scan_interval_};
            if (workload.parameters.size() > 1)
                population_.emplace(workload.parameters, scan_interval_, limit);
            else
                population_.emplace(workload.parameters.front(), workload.neurons, scan_interval_, limit);
        } catch (const ParameterError& error) {
            throw Unserved(error.what());
        }
    }

    void run(const Workload& workload, Trains& trains) override {
        carry_out(workload, [&](std::size_t row) {
            const TimePoint begin = population_->time();
            population_->advance_unrounded(workload.row(row), [&](std::uint32_t i, Interval span) {
                note(workload, trains, i, {begin, span});
            });
        });
    }
    std::size_t count(const Workload& workload) override {
        std::size_t spikes = 0;
        carry_out(workload, [&](std::size_t row) {
            population_->advance(workload.row(row), [&](TimePoint, std::uint32_t) { ++spikes; });
        });
        return spikes;
    }

  private:
    template <class Advance>
    void carry_out(const Workload& workload, Advance&& advance) {
        population_->reset();
        for (std::size_t row = 0; row < workload.rows(); ++row) {
            while (population_->time() < workload.end(row)) {
                advance(row);
                if (population_->storm()) throw Unserved("a storm of spikes, more than 1000 in a scan");
            }
        }
    }

    static LifParameters hardest(const Workload& workload) {
        LifParameters parameters = workload.parameters.front();
        for (const LifParameters& each : workload.parameters)
            parameters.delta_g = std::max(parameters.delta_g, each.delta_g);
        return parameters;
    }

    Duration scan_interval_{};
    std::optional<DensePopulation> population_;
};

}  // namespace

std::vector<std::string> exact_solver_names() { return {"exact", "dense"}; }

std::unique_ptr<Solver> make_exact_solver(const SolverSpec& spec) {
    if (spec.name == "exact") return std::make_unique<SparseSolver>();
    if (spec.name == "dense") return std::make_unique<DenseSolver>();
    return nullptr;
}

}  // namespace afferent::bench
