// Neurons by a vectorised sweep per frame: for busy populations on a frame clock.
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

// The same events as SparsePopulation, within 1 ns, for drives that change at multiples of the frame interval
// only. A sweep carries every neuron over the frame by polynomials in its conductance; v cannot cross the
// threshold unseen, so those above it at the end are the ones that have fired. Their spikes are solved in
// batches by a power series, and what the series does not serve (a grazing spike, an extreme conductance) is
// left to the model itself. Neurons in their refractory period are listed, and join the batch where it ends.
//
// After construction nothing is allocated while the neurons fire at most twice in a frame on the average,
// nothing locked and nothing thrown.
class DensePopulation {
  public:
    using Index = std::uint32_t;

    // Why the dense form does not serve this model with this frame; nothing if it does.
    static std::optional<std::string> refusal(const NeuronModel& model, Duration frame);

    // All at rest at scene_start. Throws ParameterError, also for what refusal() refuses.
    DensePopulation(const NeuronModel& model, std::size_t count, Duration frame, SpikeLimit limit = {});
    // One set of parameters for each neuron, at least one: they may differ in v_th_mv and delta_g.
    DensePopulation(std::span<const LifParameters> parameters, Duration frame, SpikeLimit limit = {});
    ~DensePopulation();
    DensePopulation(DensePopulation&&) noexcept;
    DensePopulation& operator=(DensePopulation&&) noexcept;

    std::size_t size() const noexcept;
    std::size_t bytes() const noexcept;
    // The same before it is built, for neurons that are alike. The model is not refused.
    static std::size_t bytes(const NeuronModel& model, std::size_t count) noexcept;
    Duration frame() const noexcept { return frame_; }
    // Up to which the population has been advanced.
    TimePoint time() const noexcept { return time_; }
    // The instruction set in use.
    const char* instructions() const noexcept;

    // One frame, under one drive for each neuron: sink(time, index) for its spikes, in the order of (time,
    // index).
    template <class Sink>
    void advance(std::span<const double> drives_mv, Sink&& sink) {
        for (const std::uint64_t key : spikes(drives_mv))
            sink(time_ + Duration(static_cast<Duration::rep>(key >> 32)), static_cast<Index>(key));
        time_ += frame_;
    }

    // The same, for measurements: sink(index, span since the frame's beginning), not rounded, in no order
    // between neurons.
    template <class Sink>
    void advance_unrounded(std::span<const double> drives_mv, Sink&& sink) {
        const Unrounded spikes = unrounded_spikes(drives_mv);
        for (std::size_t i = 0; i < spikes.keys.size(); ++i)
            sink(static_cast<Index>(spikes.keys[i]), Interval(spikes.times_ns[i]));
        time_ += frame_;
    }

    // The first neuron that fired more often in a frame than the limit allows for its length. It has stopped
    // firing: the run is to end.
    const std::optional<SpikeStorm>& storm() const noexcept;

    void reset() noexcept;

  private:
    class Sweeper;

    // Sorted: nanoseconds into the frame << 32 | index.
    std::span<const std::uint64_t> spikes(std::span<const double> drives_mv);

    struct Unrounded {
        std::span<const std::uint64_t> keys;
        std::span<const double> times_ns;
    };
    Unrounded unrounded_spikes(std::span<const double> drives_mv);

    Duration frame_;
    TimePoint time_ = scene_start;
    std::unique_ptr<Sweeper> sweeper_;
};

}  // namespace afferent
