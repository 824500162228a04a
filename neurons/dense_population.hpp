// Neurons by a vectorised sweep per scan interval: for busy populations whose samples come on a clock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "afferent/neurons/models.hpp"
#include "afferent/neurons/spike_limit.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// Gives the events of SparsePopulation, within 1 ns, for drives that change only at multiples of the scan
// interval. A sweep advances every neuron over the interval by polynomials in its conductance. v crosses the
// threshold at most once, so the neurons above it at the end are those that have fired. Their spikes are
// solved in batches by a power series. The cases that the series does not cover (a grazing spike, an extreme
// conductance) are computed one by one by AdaptingLif. Neurons in their refractory period are kept in a list
// and join the batch when the period ends.
//
// After construction nothing is locked or thrown, and nothing is allocated while neurons fire at most twice
// per scan interval on average.
class DensePopulation {
  public:
    using Index = std::uint32_t;

    // Why the dense form does not serve this model with this scan interval; nothing if it does.
    static std::optional<std::string> refusal(const NeuronModel& model, Duration scan_interval);

    // All at rest at scene_start. Throws ParameterError, also for what refusal() refuses.
    DensePopulation(const NeuronModel& model, std::size_t count, Duration scan_interval,
                    SpikeLimit limit = {});
    // One set of parameters for each neuron, at least one: they may differ in v_th_mv and delta_g. Each
    // begins at its phase, in [0, 1), of the way from v_r to v_th; without phases all begin at rest.
    DensePopulation(std::span<const LifParameters> parameters, Duration scan_interval, SpikeLimit limit = {},
                    std::span<const double> phases = {});
    ~DensePopulation();
    DensePopulation(DensePopulation&&) noexcept;
    DensePopulation& operator=(DensePopulation&&) noexcept;

    std::size_t size() const noexcept;
    std::size_t bytes() const noexcept;
    // The same before it is built, for neurons that are alike. The model is not refused.
    static std::size_t bytes(const NeuronModel& model, std::size_t count) noexcept;
    Duration scan_interval() const noexcept { return scan_interval_; }
    // The population has been advanced up to this time.
    TimePoint time() const noexcept { return time_; }
    // The instruction set in use.
    const char* instructions() const noexcept;

    // Advances by one scan interval with one drive for each neuron, and calls sink(time, index) for every
    // spike, in the order of (time, index).
    template <class Sink>
    void advance(std::span<const double> drives_mv, Sink&& sink) {
        for (const std::uint64_t key : spikes(drives_mv))
            sink(time_ + Duration(static_cast<Duration::rep>(key >> 32)), static_cast<Index>(key));
        time_ += scan_interval_;
    }

    // The same for measurements: sink(index, span since the interval began), not rounded. The spikes of each
    // neuron are in order.
    template <class Sink>
    void advance_unrounded(std::span<const double> drives_mv, Sink&& sink) {
        const Unrounded spikes = unrounded_spikes(drives_mv);
        for (std::size_t i = 0; i < spikes.keys.size(); ++i)
            sink(static_cast<Index>(spikes.keys[i]), Interval(spikes.times_ns[i]));
        time_ += scan_interval_;
    }

    // The first neuron that fired more often in a scan interval than the limit allows. It has stopped firing;
    // the caller ends the run.
    const std::optional<SpikeStorm>& storm() const noexcept;

    void reset() noexcept;

  private:
    class Sweeper;

    // Sorted: nanoseconds since the interval began << 32 | index.
    std::span<const std::uint64_t> spikes(std::span<const double> drives_mv);

    struct Unrounded {
        std::span<const std::uint64_t> keys;
        std::span<const double> times_ns;
    };
    Unrounded unrounded_spikes(std::span<const double> drives_mv);

    Duration scan_interval_;
    TimePoint time_ = scene_start;
    std::unique_ptr<Sweeper> sweeper_;
};

}  // namespace afferent
