// How often the afferents fired, weighted by an exponential kernel that forgets the past.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "afferent/decoders/silence.hpp"
#include "afferent/runtime/event.hpp"

namespace afferent {

// The rate is the weighted count of spikes over the weighted time that is known. An instant of age a has the
// weight e^(−a/tau)/tau, which integrates to 1 over the past:
//
//     rate = Σ e^(−a/tau)/tau over the spikes  /  ∫ e^(−a/tau)/tau da over the known ages
//
// Unknown and lost time lies in neither, so it does not bias the rate.
//
// Uncertainty. For a regular train with interval P and uniform phase the variance of this rate is
//
//     ((x/2) coth(x/2) − 1)/P²,  x = P/tau,      which never exceeds  1/(12 tau²)
//
// and tends to that bound as x → 0. (Let φ be the age of the latest spike, uniform in [0, P). The rate is
// e^(−φ/tau)/(tau (1 − e^(−x))); take its first two moments.) The bound is the variance V²/12 of a sawtooth
// whose height V is that of the kernel's step at age 0. Each boundary between known and unknown time is
// another step, as high as the kernel is there. Averaged over rates their sawteeth are uncorrelated, so the
// variances add:
//
//     variance = (1/12) Σ V² / known²          V = 1/tau at age 0, e^(−a/tau)/tau at a boundary of age a
//
// The step at age 0 counts in full even if the most recent time is unknown, because a spike there would have
// that weight; so sigma grows as 1/known while no packet arrives. A sliding window T has two steps of 1/T,
// and thus a variance of 1/(6 T²): where all is known, this rate is as certain as that of a window of √2 ·
// tau.
//
// One exponential for each event, and two for each span. Allocates nothing after construction.
class ExponentialRate {
  public:
    // read[address]: whether its events are counted. each: count each address by itself, too. Throws
    // ParameterError: time_constant > 0.
    ExponentialRate(std::vector<bool> read, Duration time_constant, bool each);

    // As for SpikeRate.
    void observe(TimePoint begin, TimePoint end, std::span<const Event> events) noexcept;
    void lose(TimePoint begin, TimePoint end) noexcept;
    void presume_silence(TimePoint until) noexcept {
        state_.presumed_until = std::max(state_.presumed_until, until);
    }
    void resume(TimePoint start, TimePoint heard_until) noexcept;
    TimePoint heard_until() const noexcept { return state_.heard_until; }
    Duration time_constant() const noexcept { return time_constant_; }

    // The counts at one time.
    class At;
    At at(TimePoint now) const noexcept;

    // A number of spikes that decays; as it was at `time`.
    struct Count {
        TimePoint time;
        double spikes = 0;
        friend bool operator==(const Count&, const Count&) = default;
    };
    // The part of the kernel that is known.
    struct Known {
        TimePoint time;         // ages count from here
        double weight = 0;      // 0 to 1
        double boundaries = 0;  // Σ e^(−2a/tau) over boundaries between known and unknown
        TimePoint since;        // the last boundary
        bool last = false;      // whether the time from there on is known
        friend bool operator==(const Known&, const Known&) = default;
    };
    struct Snapshot {
        TimePoint heard_until, presumed_until;
        TimePoint counted_from;  // events before the start, or in a span that is lost, do not count
        Known known;
        Count all;
        std::vector<Count> each;  // by address, where each is counted
        friend bool operator==(const Snapshot&, const Snapshot&) = default;
    };
    const Snapshot& snapshot() const noexcept { return state_; }
    // Throws ParameterError, and changes nothing, if the snapshot is of another number of addresses.
    void resume(const Snapshot& snapshot);

    // Its memory on the heap.
    std::size_t heap_bytes() const noexcept;

  private:
    double decay(Duration age) const noexcept {
        return std::exp(-static_cast<double>(std::max(age, Duration(0)).count()) / tau_ns_);
    }
    void pass(Known& known, TimePoint until, bool is_known) const noexcept;
    void take_back(Known& known, TimePoint from) const noexcept;
    void add(Count& count, TimePoint time) const noexcept;

    std::vector<bool> read_;
    Duration time_constant_;
    double tau_ns_;
    Duration as_known_as_;  // a sliding window that is as certain
    Snapshot state_;
};

// As SpikeCounts (grip_estimator.hpp). Valid until the rate changes.
class ExponentialRate::At {
  public:
    double events() const noexcept { return at_now(rate_->state_.all); }
    // Only where each address is counted by itself.
    double events_of(Address address) const noexcept { return at_now(rate_->state_.each[address]); }
    double known_s() const noexcept { return known_s_; }
    double window_s() const noexcept { return window_s_; }
    // The kernel's step at age 0 is 1/tau high, so that the rate swings by half of it about its mean at most.
    double short_hz(double) const noexcept { return 0.5 / known_s_; }
    double spike_hz() const noexcept {
        return 2 * window_s_ < seconds(rate_->as_known_as_) ? 1 / known_s_ : 0;
    }
    double allowed_hz() const noexcept { return allowed_since(rate_->state_.all); }
    double allowed_hz_of(Address address) const noexcept {
        return allowed_since(rate_->state_.each[address]);
    }

  private:
    friend class ExponentialRate;
    At(const ExponentialRate& rate, TimePoint now, double known_s, double window_s) noexcept
        : rate_(&rate), now_(now), known_s_(known_s), window_s_(window_s) {}

    // A sliding window of √2 tau would be empty.
    double allowed_since(const Count& count) const noexcept {
        if (!(count.spikes > 0)) return 0;
        const Snapshot& state = rate_->state_;
        const TimePoint until = std::min(now_, std::max(state.heard_until, state.presumed_until));
        return afferent::allowed_hz(count.time, state.counted_from, until, rate_->as_known_as_);
    }
    double at_now(const Count& count) const noexcept {
        return count.spikes * rate_->decay(now_ - count.time);
    }

    const ExponentialRate* rate_;
    TimePoint now_;
    double known_s_;
    double window_s_;
};

}  // namespace afferent
