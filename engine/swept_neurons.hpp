// The neurons of a shard by a sweep per scan.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <optional>
#include <span>
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
        : population_(std::move(population)), drives_mv_(population_.take_drives()) {
        waiting_.reserve(population_.size() / 4);
    }

    template <class Sink>
    void begin_window(TimePoint until, Sink&& sink) {
        until_ = until;
        std::erase_if(waiting_, [&](std::uint64_t key) {
            const TimePoint time = swept_from_ + Duration(static_cast<Duration::rep>(key >> 32));
            if (time > until) return false;
            sink(time, static_cast<std::uint32_t>(key));
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
        // Those of the interval before have been taken: it ended within this window.
        assert(waiting_.empty());
        swept_from_ = population_.time();
        population_.advance(drives_mv_, [&](TimePoint time, std::uint32_t i) {
            if (time <= until_)
                sink(time, i);
            else
                waiting_.push_back(static_cast<std::uint64_t>((time - swept_from_).count()) << 32 | i);
        });
    }
    TimePoint time() const noexcept { return population_.time(); }
    TimePoint until() const noexcept { return until_; }
    DensePopulation& population() noexcept { return population_; }
    std::span<const double> drives_mv() const noexcept { return drives_mv_; }

    const std::optional<SpikeStorm>& storm() const noexcept { return population_.storm(); }
    void reset() {
        population_.reset();
        std::ranges::fill(drives_mv_, 0.0);
        waiting_.clear();
    }
    std::size_t bytes() const noexcept {
        return sizeof *this - sizeof population_ + population_.bytes() + drives_mv_.size() * sizeof(double) +
               waiting_.capacity() * sizeof(std::uint64_t);
    }
    static constexpr bool is_dense() noexcept { return true; }
    static constexpr std::uint64_t form_changes() noexcept { return 0; }

  private:
    DensePopulation population_;
    std::span<double> drives_mv_;
    // Spikes of the interval that was swept last, but after the window: nanoseconds since it began << 32 |
    // index.
    std::vector<std::uint64_t> waiting_;
    TimePoint swept_from_ = scene_start;
    TimePoint until_ = scene_start;
};

}  // namespace afferent
