// Neurons by prediction: each is computed only at its own events, a new drive or a spike.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "afferent/neurons/elements.hpp"
#include "afferent/neurons/neuron.hpp"
#include "afferent/neurons/spike_limit.hpp"
#include "afferent/runtime/indexed_queue.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {

// Each neuron has its own real-valued time: an integer stamp and a remainder. A spike is stamped with the
// first whole nanosecond at or after it. So a spike is at or before T exactly if its stamp is, and a drive
// that changes at T changes every spike after T and none before. The neuron keeps the remainder, so stamps
// are rounded and neurons are not.
//
// The queue holds one entry for each neuron that will fire under its present drive: its predicted spike, or a
// cheaper lower bound on it if the neuron offers one. When a bound comes up, the spike is computed exactly,
// from the same state and so with the same result as if it had been computed at once.
//
// After construction nothing is allocated, locked or thrown.
template <Neuron N, class Elements = Alike<N>>
class SparsePopulation {
    struct Slot {
        typename N::State state;
        TimePoint stamp = scene_start;
        double remainder_ns = 0;  // own time is stamp + remainder; in (−1, 0]
        double drive_mv = 0;
        double span_ns =
            0;  // from own time to the predicted spike; negative while only a bound on it is known
        std::uint32_t window = 0;
        std::uint32_t spikes = 0;  // in that window
    };

  public:
    using Index = IndexedQueue::Index;

    static constexpr std::size_t bytes_per_neuron =
        sizeof(Slot) + sizeof(IndexedQueue::Entry) + sizeof(Index);

    // All at their start, which is at rest where neurons are alike, at scene_start with drive 0.
    SparsePopulation(N neuron, std::size_t count, SpikeLimit limit = {})
        : SparsePopulation(Elements(std::move(neuron)), count, limit) {}
    SparsePopulation(Elements elements, std::size_t count, SpikeLimit limit = {})
        : elements_(std::move(elements)), limit_(limit), slots_(count), queue_(count) {
        require(limit.window > Duration(0), "window", "> 0 ns", static_cast<double>(limit.window.count()));
        reset();
    }

    std::size_t size() const noexcept { return slots_.size(); }
    std::size_t bytes() const noexcept { return size_of(size()); }
    // bytes() of a population before it is built.
    static constexpr std::size_t size_of(std::size_t count) noexcept {
        return sizeof(SparsePopulation) + count * bytes_per_neuron + Elements::bytes(count);
    }

    // The population has been advanced to that time. Setting the present drive again changes nothing.
    void set_drive(Index index, TimePoint time, double drive_mv) noexcept {
        Slot& slot = slots_[index];
        if (slot.drive_mv == drive_mv) return;
        const N& neuron = elements_[index];
        if constexpr (RemembersIntervals<N>)
            neuron.advance(slot.state, slot.drive_mv, span(slot, time), expm1_);
        else
            neuron.advance(slot.state, slot.drive_mv, span(slot, time));
        slot.stamp = time;
        slot.remainder_ns = 0;
        slot.drive_mv = drive_mv;
        // Spikes up to this time have been handed out.
        predict(index, slot, time + Duration(1));
    }

    // Fires every spike with a stamp up to and including `until`, in the order of (time, index), and calls
    // sink(time, index), or sink(time, index, rest) if the sink takes it: the spike came at time + rest.
    template <class Sink>
    void advance(TimePoint until, Sink&& sink) {
        while (!queue_.empty() && queue_.next().time <= until) {
            const auto [time, index] = queue_.next();
            Slot& slot = slots_[index];
            const N& neuron = elements_[index];
            if (slot.span_ns < 0) {
                enter(index, slot, neuron.next_spike(slot.state, slot.drive_mv).count(), time);
                continue;
            }
            const double ahead_ns = slot.remainder_ns + slot.span_ns;
            const double whole_ns = std::ceil(ahead_ns);
            slot.stamp += Duration(static_cast<Duration::rep>(whole_ns));
            slot.remainder_ns = ahead_ns - whole_ns;
            if constexpr (FiresAfter<N>) {
                neuron.fire_after(slot.state, Interval(slot.span_ns));
            } else {
                neuron.advance(slot.state, slot.drive_mv, Interval(slot.span_ns));
                neuron.fire(slot.state);
            }
            if constexpr (std::is_invocable_v<Sink, TimePoint, Index, Interval>)
                sink(time, index,
                     Interval(static_cast<double>((slot.stamp - time).count()) + slot.remainder_ns));
            else
                sink(time, index);
            if (within_limit(slot)) {
                predict(index, slot, time);
            } else {
                if (!storm_) storm_ = SpikeStorm{index, time};
                queue_.remove(index);
            }
        }
    }

    // The next spike, or an earlier time; the largest where no neuron will fire under its present drive.
    TimePoint next() const noexcept { return queue_.empty() ? TimePoint::max() : queue_.next().time; }

    // The state at a time up to which the population has been advanced.
    typename N::State state(Index index, TimePoint time) const noexcept {
        const Slot& slot = slots_[index];
        typename N::State state = slot.state;
        elements_[index].advance(state, slot.drive_mv, span(slot, time));
        return state;
    }
    // Puts the neuron into that state, at a time up to which spikes have been handed out.
    void restore(Index index, TimePoint time, const typename N::State& state, double drive_mv) noexcept {
        Slot& slot = slots_[index];
        slot.state = state;
        slot.stamp = time;
        slot.remainder_ns = 0;
        slot.drive_mv = drive_mv;
        predict(index, slot, time + Duration(1));
    }
    // Nothing fires until neurons are restored, each of them.
    void suspend() noexcept { queue_.clear(); }

    // The first neuron that exceeded the limit. It has stopped firing; the caller ends the run.
    const std::optional<SpikeStorm>& storm() const noexcept { return storm_; }

    void reset() {
        queue_.clear();
        storm_.reset();
        for (std::size_t i = 0; i < size(); ++i) {
            const auto index = static_cast<Index>(i);
            slots_[i] = {.state = elements_.start(index)};
            predict(index, slots_[i], scene_start + Duration(1));
        }
    }

  private:
    static Interval span(const Slot& slot, TimePoint until) noexcept {
        return Interval(static_cast<double>((until - slot.stamp).count()) - slot.remainder_ns);
    }

    void predict(Index index, Slot& slot, TimePoint not_before) noexcept {
        const N& neuron = elements_[index];
        if constexpr (BoundsNextSpike<N>) {
            const double bound_ns = neuron.earliest_spike(slot.state, slot.drive_mv).count();
            enter(index, slot, bound_ns, not_before);
            slot.span_ns = -1;
        } else {
            enter(index, slot, neuron.next_spike(slot.state, slot.drive_mv).count(), not_before);
        }
    }

    void enter(Index index, Slot& slot, double span_ns, TimePoint not_before) noexcept {
        constexpr double representable_ns = 4e18;  // 127 years
        if (!(span_ns < representable_ns)) return queue_.remove(index);
        slot.span_ns = span_ns;
        const Duration ahead(static_cast<Duration::rep>(std::ceil(slot.remainder_ns + span_ns)));
        queue_.schedule(index, std::max(slot.stamp + ahead, not_before));
    }

    bool within_limit(Slot& slot) const noexcept {
        const auto window = static_cast<std::uint32_t>((slot.stamp - scene_start) / limit_.window);
        if (slot.window != window) {
            slot.window = window;
            slot.spikes = 0;
        }
        return ++slot.spikes <= limit_.spikes;
    }

    Elements elements_;
    SpikeLimit limit_;
    std::vector<Slot> slots_;
    IndexedQueue queue_;
    RememberedExpm1 expm1_;
    std::optional<SpikeStorm> storm_;
};

}  // namespace afferent
