// The neurons of a shard by prediction while little happens, and by a sweep per scan while much does.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "afferent/engine/predicted_neurons.hpp"
#include "afferent/engine/swept_neurons.hpp"

namespace afferent {

// When a shard changes its form. Work is what prediction is charged for in a scan interval: a new drive
// counts once and a spike twice, about as their costs compare. A unit of work costs as much as the sweep of
// thirty to a hundred neurons (`afferent bench scale`). Between the two levels a shard keeps its form, and a
// change takes several intervals in a row, so that a single scan of all elements, or a pause of a few
// intervals, changes nothing.
struct FormChange {
    double dense_from = 0.04;  // of work for each neuron
    double sparse_below = 0.02;
    std::uint32_t busy_scans = 3;
    std::uint32_t quiet_scans = 20;
};

// Has the members of PredictedNeurons. What happens depends on the shard's own scans and spikes, and so
// neither on threads nor on windows. A change of form carries the exact state of each neuron over.
template <Neuron N, class Elements = Alike<N>>
class SwitchingNeurons {
  public:
    SwitchingNeurons(PredictedNeurons<N, Elements> predicted, SweptNeurons swept, FormChange change = {})
        : predicted_(std::move(predicted)), swept_(std::move(swept)), change_(change) {}

    template <class Sink>
    void begin_window(TimePoint until, Sink&& sink) {
        predicted_.begin_window(until, sink);
        swept_.begin_window(until, sink);
    }
    template <class Sink>
    void begin_scan(TimePoint time, Sink&& sink) {
        sweep_before(time, sink);
        if (!dense_) predicted_.begin_scan(time, counted(sink));
    }
    // A loop for each form: that of the dense one can be in vectors.
    template <class Use>
    void set_drives(TimePoint time, Use&& use) {
        const double* const before_mv = swept_.drives_mv().data();
        std::uint64_t changed = 0;
        swept_.set_drives(time, [&](auto&& set) {
            const auto note = [&](std::size_t i, double drive_mv) {
                changed += before_mv[i] != drive_mv;
                set(i, drive_mv);
            };
            if (dense_) return use(note);
            predicted_.set_drives(time, [&](auto&& set_predicted) {
                use([&](std::size_t i, double drive_mv) {
                    note(i, drive_mv);
                    set_predicted(i, drive_mv);
                });
            });
        });
        work_ += changed;
    }
    void end_scan(TimePoint time) {
        if (dense_) return;
        busy_ = take_work() >= change_.dense_from ? busy_ + 1 : 0;
        const bool on_clock = (time - scene_start) % swept_.population().scan_interval() == Duration(0);
        if (busy_ >= change_.busy_scans && on_clock) become_dense(time);
    }
    template <class Sink>
    void end_window(Sink&& sink) {
        sweep_before(swept_.until() + Duration(1), sink);
        if (!dense_) predicted_.end_window(counted(sink));
    }
    TimePoint next() const noexcept { return dense_ ? swept_.next() : predicted_.next(); }

    const std::optional<SpikeStorm>& storm() const noexcept {
        return swept_.storm() ? swept_.storm() : predicted_.storm();
    }
    void reset() {
        predicted_.reset();
        swept_.reset();
        dense_ = false;
        work_ = 0;
        busy_ = quiet_ = 0;
        form_changes_ = 0;
    }
    std::size_t bytes() const noexcept {
        return sizeof *this - sizeof predicted_ - sizeof swept_ + predicted_.bytes() + swept_.bytes();
    }
    bool is_dense() const noexcept { return dense_; }
    std::uint64_t form_changes() const noexcept { return form_changes_; }

  private:
    template <class Sink>
    auto counted(Sink& sink) {
        return [this, &sink](TimePoint time, std::uint32_t i) {
            work_ += 2;
            sink(time, i);
        };
    }

    // The work since the last call, for each neuron.
    double take_work() noexcept {
        return static_cast<double>(std::exchange(work_, 0)) / static_cast<double>(swept_.population().size());
    }

    // Sweeps the intervals that begin before that time, for as long as there is work.
    template <class Sink>
    void sweep_before(TimePoint time, Sink&& sink) {
        while (dense_ && swept_.time() < time) {
            quiet_ = take_work() < change_.sparse_below ? quiet_ + 1 : 0;
            if (quiet_ >= change_.quiet_scans)
                become_sparse();
            else
                swept_.sweep(counted(sink));
        }
    }

    void become_dense(TimePoint time) {
        swept_.population().restore(
            time, [&](std::uint32_t i) { return to_lif_state(predicted_.population().state(i, time)); });
        predicted_.population().suspend();
        changed(true);
    }

    void become_sparse() {
        swept_.population().for_each_state([&](std::uint32_t i, const LifState& state) {
            predicted_.population().restore(i, swept_.time(), from_lif_state<typename N::State>(state),
                                            swept_.drives_mv()[i]);
        });
        changed(false);
    }

    void changed(bool dense) noexcept {
        dense_ = dense;
        busy_ = quiet_ = 0;
        ++form_changes_;
    }

    PredictedNeurons<N, Elements> predicted_;
    SweptNeurons swept_;
    FormChange change_;
    bool dense_ = false;
    std::uint64_t work_ = 0;   // since the last look
    std::uint32_t busy_ = 0;   // scans in a row
    std::uint32_t quiet_ = 0;  // intervals in a row
    std::uint64_t form_changes_ = 0;
};

}  // namespace afferent
