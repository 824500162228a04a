// Neurons that share their time constants and reversal potential, swept together: a part of a
// DensePopulation.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "afferent/neurons/adapting_lif.hpp"
#include "afferent/neurons/dense_columns.hpp"
#include "afferent/neurons/dense_plan.hpp"
#include "afferent/neurons/dense_population.hpp"

namespace afferent {

struct DenseScratch {
    explicit DenseScratch(std::size_t neurons) : columns{.room = neurons} {}

    dense::Columns columns;
    dense::Batch first;     // those that reach threshold in the step
    dense::Batch again;     // those that have fired, and reach it again
    dense::Batch after;     // the same, after a spike of `again`
    dense::Batch hard;      // those that are left to carry_alone()
    dense::Batch released;  // those whose refractory period has ended
    std::vector<std::uint64_t> keys;
    std::vector<double> times_ns;  // of the keys, if they are asked for
    // Used by populations that consist of several parts: the drives of one part, and the keys and times of
    // all.
    std::vector<double> drives_mv;
    std::vector<std::uint64_t> all_keys;
    std::vector<double> all_times_ns;

    std::shared_ptr<const dense::Plan> plan(const LifParameters& parameters, Duration scan_interval) {
        for (const Planned& each : plans_)
            if (each.parameters == parameters && each.scan_interval == scan_interval) return each.plan;
        plans_.push_back({parameters, scan_interval,
                          std::make_shared<const dense::Plan>(dense::plan(parameters, scan_interval))});
        return plans_.back().plan;
    }

  private:
    struct Planned {
        LifParameters parameters;
        Duration scan_interval;
        std::shared_ptr<const dense::Plan> plan;
    };
    std::vector<Planned> plans_;
};

class DenseSweeper {
  public:
    using Index = DensePopulation::Index;

    // `parameters` are those of all neurons, or where `each` has its own threshold and Δg the others, with
    // the largest Δg. To be reset before the first sweep.
    DenseSweeper(const LifParameters& parameters, std::span<const LifParameters> each, std::size_t count,
                 Duration scan_interval, SpikeLimit limit, std::shared_ptr<DenseScratch> scratch);

    DenseSweeper(DenseSweeper&&) = default;  // a copy would share its arrays

    // To the beginning, with each neuron at its phase.
    void reset(const Phases& phase_of);

    // The keys of DensePopulation::spikes(), until the next sweep with that scratch memory.
    std::span<const std::uint64_t> sweep(std::span<const double> drives_mv, TimePoint begin);
    // The times of these keys, before rounding.
    std::span<const double> sweep_unrounded(std::span<const double> drives_mv, TimePoint begin);
    std::span<const std::uint64_t> keys() const noexcept { return keys_; }

    std::size_t bytes() const noexcept;
    // bytes() of one that is yet to be built.
    static std::size_t size_of(const LifParameters& parameters, std::span<const LifParameters> each,
                               std::size_t count) noexcept;

    void for_each_state(const std::function<void(Index, const LifState&)>& use) const;
    void restore(const std::function<LifState(Index)>& state_of);
    const char* instructions() const noexcept { return kernel_.name; }
    const std::optional<SpikeStorm>& storm() const noexcept { return storm_; }

  private:
    // A neuron in its refractory period at the end of a step, with what is left of the period and its
    // conductance at that time.
    struct Resting {
        Index index;
        double left;  // in units of tau_m
        double g;
    };

    bool adapts() const noexcept { return plan_->model.adapts; }
    double v_th_mv(std::size_t index) const noexcept {
        return v_th_mv_.empty() ? parameters_.v_th_mv : v_th_mv_[index];
    }
    double delta_g(std::size_t index) const noexcept {
        return delta_g_.empty() ? parameters_.delta_g : delta_g_[index];
    }
    // By which g decays in so many steps, but not 0.
    double scale_after(std::int64_t steps) const noexcept {
        return adapts() ? std::max(std::exp(-static_cast<double>(steps) * plan_->model.step / plan_->model.a),
                                   1e-200)
                        : 1;
    }
    // g at the end of the step.
    void store_g(std::size_t index, double g) noexcept {
        if (adapts()) scaled_g_[index] = g / end_scale_;
    }
    void rescale(std::size_t begin, std::size_t count, double scale) noexcept;
    // `last`: no crossing may wait for the next tile.
    void carry(std::span<const double> drives_mv, std::size_t tile, std::size_t size, int step, bool last,
               TimePoint begin);
    void fire_crossings(const dense::Neurons& neurons, double start_ns, bool last, TimePoint begin);
    // The first `count` neurons of the batch fire and leave it. Those that reach threshold again are appended
    // to `again`.
    void fire(const dense::Neurons& neurons, double start_ns, dense::Batch& crossing, std::size_t count,
              dense::Batch& again);
    // The factor by which g decays in that time.
    double kept(double units) const noexcept { return std::exp(-units / plan_->model.a); }
    double fall_or_decay(double units) const noexcept {
        return plan_->model.adapts ? std::expm1(-units / plan_->model.a) : std::exp(-units);
    }
    // The sweep has advanced neurons in their refractory period like the others; their results are
    // overwritten here. They rest to the end of the step or continue from where their period ends.
    void release(std::vector<Resting>& resting, const dense::Neurons& neurons,
                 std::span<const double> drives_mv, dense::Batch& crossing);
    // Every neuron of the batch has just fired.
    void rest(const dense::Neurons& neurons, dense::Batch& batch);
    void begin_rest(std::size_t index, double left, double g);
    // Leaves the neurons of the batch to carry_alone().
    void leave_to_carry_alone(dense::Batch& batch) noexcept;
    // Advances one neuron by AdaptingLif, from where the batch left it to the end of the step.
    void carry_alone(std::size_t at, std::span<const double> drives_mv, double start_ns, TimePoint begin);
    void note_storm(std::size_t index, TimePoint begin) noexcept {
        if (!storm_) storm_ = SpikeStorm{static_cast<Index>(index), begin};
    }

    std::shared_ptr<DenseScratch> scratch_;
    std::shared_ptr<const dense::Plan> plan_;
    dense::Kernel kernel_;
    AdaptingLif neuron_;
    Membrane membrane_;
    LifParameters parameters_;  // of all; where each has its own, the largest Δg
    double scan_interval_ns_;
    double spikes_per_step_ = 0;
    std::size_t count_;
    std::int64_t passed_ = 0;  // steps since scaled_g_ was g itself
    bool forgets_ = false;     // g decays so far in a step that its factor is taken into it each time
    double end_scale_ = 1;     // of g, at the end of the step that is carried out
    std::array<double, dense::most_steps + 1> scales_;  // of g, at the ends of the steps of this sweep
    double period_;                                     // refractory, in units of tau_m; 0 if there is none
    dense::Batch& hard_ = scratch_->hard;
    dense::Batch& released_ = scratch_->released;
    std::vector<std::uint64_t>& keys_ = scratch_->keys;
    std::vector<double>& times_ns_ = scratch_->times_ns;
    std::span<double> gap_mv_;  // this and the next three lie in the columns of the scratch memory
    std::span<double> scaled_g_;
    std::span<double> v_th_mv_;
    std::span<double> delta_g_;
    std::vector<std::vector<Resting>> resting_;  // by tile
    std::vector<std::uint8_t> rests_;            // by neuron: 1 in its refractory period
    bool unrounded_ = false;
    std::optional<SpikeStorm> storm_;
};

}  // namespace afferent
