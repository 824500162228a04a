// The neurons of a shard by a sweep per scan.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "afferent/neurons/dense_population.hpp"
#include "afferent/runtime/event.hpp"

namespace afferent {

// Has the members of PredictedNeurons. Drives change at multiples of the scan interval only: a late sample,
// off that clock, acts at the next multiple. The spikes of an interval are computed at its beginning; those
// that come after the window wait for the next.
class SweptNeurons {
  public:
    explicit SweptNeurons(DensePopulation population)
        : population_(std::move(population)), drives_mv_(population_.size()) {
        waiting_.reserve(population_.size() / 4);
    }

    template <class Sink>
    void begin_window(TimePoint until, Sink&& sink) {
        until_ = until;
        std::erase_if(waiting_, [&](const Event& event) {
            if (event.time > until) return false;
            sink(event.time, event.address);
            return true;
        });
    }
    template <class Sink>
    void begin_scan(TimePoint time, Sink&& sink) {
        // Up to the scan's time, but not beyond: its drives hold from there on.
        while (population_.time() < time) sweep(sink);
    }
    template <class Use>
    void set_drives(TimePoint, Use&& use) {
        double* const drives_mv = drives_mv_.data();
        use([drives_mv](std::size_t i, double drive_mv) { drives_mv[i] = drive_mv; });
    }
    void end_scan(TimePoint) noexcept {}
    template <class Sink>
    void end_window(Sink&& sink) {
        while (population_.time() <= until_) sweep(sink);
    }
    TimePoint next() const noexcept { return waiting_.empty() ? population_.time() : TimePoint::min(); }

    // The interval that begins at time().
    template <class Sink>
    void sweep(Sink&& sink) {
        population_.advance(drives_mv_, [&](TimePoint time, std::uint32_t i) {
            if (time <= until_)
                sink(time, i);
            else
                waiting_.push_back({time, i});
        });
    }
    TimePoint time() const noexcept { return population_.time(); }
    TimePoint until() const noexcept { return until_; }
    DensePopulation& population() noexcept { return population_; }
    const std::vector<double>& drives_mv() const noexcept { return drives_mv_; }

    const std::optional<SpikeStorm>& storm() const noexcept { return population_.storm(); }
    void reset() noexcept {
        population_.reset();
        std::fill(drives_mv_.begin(), drives_mv_.end(), 0.0);
        waiting_.clear();
    }
    std::size_t bytes() const noexcept {
        return sizeof *this - sizeof population_ + population_.bytes() + drives_mv_.size() * sizeof(double) +
               waiting_.capacity() * sizeof(Event);
    }
    static constexpr bool is_dense() noexcept { return true; }
    static constexpr std::uint64_t form_changes() noexcept { return 0; }

  private:
    DensePopulation population_;
    std::vector<double> drives_mv_;
    std::vector<Event> waiting_;  // swept, but after the window; the address is the index
    TimePoint until_ = scene_start;
};

}  // namespace afferent
