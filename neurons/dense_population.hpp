// Neurons by a vectorised sweep per scan interval: for busy populations whose samples come on a clock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "afferent/neurons/lif_state.hpp"
#include "afferent/neurons/models.hpp"
#include "afferent/neurons/neuron.hpp"
#include "afferent/neurons/spike_limit.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// What a sweep needs while it lasts, the constants of parameters that populations have in common, and their
// arrays, which lie together if there are no more neurons than given here. Populations that are never built
// or swept at the same time may share it; it lasts as long as any of them.
struct DenseScratch;
std::shared_ptr<DenseScratch> make_dense_scratch(std::size_t neurons = 0);

// Gives the events of SparsePopulation, within 1 ns, for drives that change only at multiples of the scan
// interval. A sweep advances every neuron over the interval by polynomials in its conductance. v crosses the
// threshold at most once, so the neurons above it at the end are those that have fired. Their spikes are
// solved in batches by a power series. The cases that the series does not cover (a grazing spike, an extreme
// conductance, any spike of a neuron that is too stiff for it) are computed one by one by AdaptingLif.
// Neurons in their refractory period are kept in a list and join the batch when the period ends.
//
// After construction nothing is locked or thrown, and nothing is allocated while no more neurons of a tile
// are in their refractory period than ever before, and neurons fire at most twice per scan interval on
// average.
class DensePopulation {
  public:
    using Index = std::uint32_t;

    // Why the dense form does not serve this model with this scan interval; nothing if it does.
    static std::optional<std::string> refusal(const NeuronModel& model, Duration scan_interval);

    // Whether a sweep of many such neurons costs less than their prediction where all drives change: not
    // where the series does not hold over a part of the interval. The parameters are not refused.
    static bool pays(const LifParameters& parameters, Duration scan_interval);

    // Each begins at its phase of the way from v_r to v_th, at scene_start. Throws ParameterError, also for
    // what refusal() refuses. Without scratch memory given, the population has its own.
    DensePopulation(const NeuronModel& model, std::size_t count, Duration scan_interval,
                    SpikeLimit limit = {}, Phases phases = {}, std::shared_ptr<DenseScratch> scratch = {});
    // One set of parameters for each neuron, at least one. Those that differ in v_th_mv and delta_g alone are
    // swept together.
    DensePopulation(std::span<const LifParameters> parameters, Duration scan_interval, SpikeLimit limit = {},
                    Phases phases = {}, std::shared_ptr<DenseScratch> scratch = {});
    ~DensePopulation();
    DensePopulation(DensePopulation&&) noexcept;
    DensePopulation& operator=(DensePopulation&&) noexcept;

    std::size_t size() const noexcept { return size_; }
    // Without the scratch memory.
    std::size_t bytes() const noexcept;
    // bytes() of a population with these parameters, before it is built.
    static std::size_t size_of(const LifParameters& parameters, std::size_t count) noexcept;
    static std::size_t size_of(std::span<const LifParameters> parameters, Duration scan_interval);
    // Returns room for a drive of each neuron, in one column with the drives of the populations that share
    // the scratch memory. bytes() does not contain it.
    std::span<double> take_drives();
    Duration scan_interval() const noexcept { return scan_interval_; }
    // The population has been advanced up to this time.
    TimePoint time() const noexcept { return time_; }
    // The instruction set in use.
    const char* instructions() const noexcept;

    // Advances by one scan interval with one drive for each neuron, and calls sink(time, index) for every
    // spike. The spikes of each neuron are in order.
    template <class Sink>
    void advance(std::span<const double> drives_mv, Sink&& sink) {
        for (const std::uint64_t key : spikes(drives_mv))
            sink(time_ + Duration(static_cast<Duration::rep>(key >> 32)), static_cast<Index>(key));
        time_ += scan_interval_;
    }

    // The same for measurements: sink(index, span since the interval began), not rounded.
    template <class Sink>
    void advance_unrounded(std::span<const double> drives_mv, Sink&& sink) {
        const Unrounded spikes = unrounded_spikes(drives_mv);
        for (std::size_t i = 0; i < spikes.keys.size(); ++i)
            sink(static_cast<Index>(spikes.keys[i]), Interval(spikes.times_ns[i]));
        time_ += scan_interval_;
    }

    // The first neuron that fired more often in a scan interval than the limit allows. It has stopped firing;
    // the caller ends the run.
    const std::optional<SpikeStorm>& storm() const noexcept { return storm_; }

    void reset();

    // Calls use(index, state) with the state at time() of each neuron, in any order.
    void for_each_state(const std::function<void(Index, const LifState&)>& use) const;
    // Goes on at that time, each neuron from state_of(index).
    void restore(TimePoint time, const std::function<LifState(Index)>& state_of);

  private:
    struct Part;

    // Calls use(part, its drives), one after the other.
    template <class Use>
    void sweep_parts(std::span<const double> drives_mv, Use&& use);

    // Nanoseconds since the interval began << 32 | index.
    std::span<const std::uint64_t> spikes(std::span<const double> drives_mv);

    struct Unrounded {
        std::span<const std::uint64_t> keys;
        std::span<const double> times_ns;
    };
    Unrounded unrounded_spikes(std::span<const double> drives_mv);

    Duration scan_interval_;
    TimePoint time_ = scene_start;
    std::size_t size_;
    std::shared_ptr<DenseScratch> scratch_;
    Phases phases_;
    std::vector<Part> parts_;  // by time constants and what else a sweep needs the same of all
    std::optional<SpikeStorm> storm_;
};

}  // namespace afferent
