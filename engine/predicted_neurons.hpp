// The neurons of a shard by prediction.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "afferent/neurons/sparse_population.hpp"

namespace afferent {

// What a shard does with its neurons (EncodedShard), whatever their form. sink(time, index) takes the spikes.
//
//     begin_window(until, sink)    a window begins, that ends at `until`
//     begin_scan(time, sink)       drives will change at that time, which lies in the window
//     set_drives(time, use)        use(set) calls set(i, drive_mv) for each drive
//     end_scan(time)               all of them have been set
//     end_window(sink)             every spike of the window has been fired
//     next()                       as Shard has it
template <Neuron N, class Elements = Alike<N>>
class PredictedNeurons {
  public:
    PredictedNeurons(Elements neurons, std::uint32_t count, SpikeLimit limit)
        : population_(std::move(neurons), count, limit) {}

    template <class Sink>
    void begin_window(TimePoint until, Sink&&) noexcept {
        until_ = until;
    }
    template <class Sink>
    void begin_scan(TimePoint time, Sink&& sink) {
        population_.advance(time, sink);
    }
    template <class Use>
    void set_drives(TimePoint time, Use&& use) {
        use([&](std::size_t i, double drive_mv) {
            population_.set_drive(static_cast<std::uint32_t>(i), time, drive_mv);
        });
    }
    void end_scan(TimePoint) noexcept {}
    template <class Sink>
    void end_window(Sink&& sink) {
        population_.advance(until_, sink);
    }
    TimePoint next() const noexcept { return population_.next(); }

    const std::optional<SpikeStorm>& storm() const noexcept { return population_.storm(); }
    void reset() { population_.reset(); }
    std::size_t bytes() const noexcept { return population_.bytes() + sizeof until_; }
    static constexpr bool is_dense() noexcept { return false; }
    static constexpr std::uint64_t form_changes() noexcept { return 0; }

    SparsePopulation<N, Elements>& population() noexcept { return population_; }

  private:
    SparsePopulation<N, Elements> population_;
    TimePoint until_ = scene_start;
};

}  // namespace afferent
