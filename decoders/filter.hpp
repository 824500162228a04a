// A decoder that keeps a belief of the grip force, which spikes and silence correct.
#pragma once

#include <vector>

#include "afferent/decoders/decoder.hpp"
#include "afferent/decoders/exponential_rate.hpp"
#include "afferent/decoders/force_belief.hpp"
#include "afferent/decoders/spike_replay.hpp"

namespace afferent {

// A spike is a linear measurement of the force: its mean over the last tau_m or so of the interval, exact but
// for the tick of its stamp and for what is not known of the adaptation (spike_replay.hpp). That an afferent
// is silent bounds the same mean from above; of the bounds of those that have been silent for longest the
// lowest counts, and is taken in every 10 ms and at every estimate. The force itself is the state of
// ForceBelief.
//
// The spikes of three milliseconds are one measurement, and one that repeats what an afferent just like it has
// said (the same interval, to the tick) says nothing: nine afferents that fire together know no more than
// one. At its full scale an element says nothing either.
//
// A spike of a transient afferent measures the size of the force's rate of change in the same way, and the
// silence of the one that fired last bounds it.
//
// What is lost is neither: it widens the belief.
//
// Afferents that contradict the others are left out: dead ones, which are silent at forces at which they
// would fire, until they fire; and wild or stuck ones, whose spikes tell other forces time and again, until
// they agree again. Every ten seconds all of them are given another chance.
//
// Hysteresis of the sensors is taken for the play that hand/sensor.hpp simulates: while the force rises the
// grip is harder than what is sensed, and while it falls it is softer.
//
// An estimate below the force at which firing begins is 0, as silence says no more.
//
// An event costs O(1), and so does an estimate. Memory: 90 bytes for each afferent, four for each address,
// and 37 kB for each ratio of time constants. Allocates nothing after construction.
class Filter {
  public:
    struct Parameters {
        ForceBelief::Parameters force;
        friend bool operator==(const Parameters&, const Parameters&) = default;
    };
    // The belief, the time of which it is, and the side on which the sensors' hysteresis is: at +1 they read
    // low, at −1 high. They change over when the force has come back from its extreme.
    struct Progress {
        ForceBelief belief;
        TimePoint time;
        double side = 1;
        double extreme_n = 0;
        // How many measurements in a row it has been back, and how far at most.
        int turning = 0;
        double turned_n = 0;
        friend bool operator==(const Progress&, const Progress&) = default;
    };
    // The spikes of three milliseconds, weighed by 1/variance; not yet in the belief, which is that of their
    // begin.
    struct Batch {
        TimePoint begin;
        double weight = 0;
        double force = 0;  // weighed
        double lag = 0;    // weighed
        friend bool operator==(const Batch&, const Batch&) = default;
    };
    // The afferents in the order of their last spikes, as a list, without those that are left out.
    struct Place {
        std::uint32_t before, after;
        std::uint16_t silences;  // how often it was silent at forces at which it would have fired
        std::uint16_t oddities;  // how much of what its spikes have told contradicted the others
        bool odd;                // and is left out for it
        friend bool operator==(const Place&, const Place&) = default;
    };
    // The last interval that a spike of a group has told.
    struct Heard {
        TimePoint begin, end;
        friend bool operator==(const Heard&, const Heard&) = default;
    };
    struct Snapshot {
        ExponentialRate::Snapshot rate;
        SpikeReplay::Snapshot replay;
        std::vector<Place> places;
        std::uint32_t listed;
        std::vector<Heard> heard;
        Progress progress;
        Batch batch;
        TimePoint measured;
        std::uint32_t speaker;
        std::uint32_t transient;
        double surprise;
        TimePoint span_begin;
        Estimate last;
        friend bool operator==(const Snapshot&, const Snapshot&) = default;
    };

    // Throws ParameterError: an afferent with a share of the grip force; each of them fires within the range
    // of the sensors.
    Filter(const Parameters& parameters, const DecodedAfferents& afferents);

    void observe(TimePoint begin, TimePoint end, std::span<const Event> events) noexcept;
    void lose(TimePoint begin, TimePoint end) noexcept;
    void presume_silence(TimePoint until) noexcept { rate_.presume_silence(until); }
    TimePoint heard_until() const noexcept { return rate_.heard_until(); }

    Estimate estimate(TimePoint now) noexcept;
    Duration history() const noexcept { return history_; }

    void restart(TimePoint start) noexcept { resume_after(start, start, {}); }
    void resume_after(TimePoint start, TimePoint heard_until, const Estimate& last) noexcept;
    void correct(const Estimate& last) noexcept { last_ = last; }
    Snapshot snapshot() const;
    void resume(const Snapshot& snapshot);

    std::size_t bytes() const noexcept;

    // Whether an afferent is left out at present.
    bool left_out(Address address) const noexcept;

  private:
    // What sampling by the sensors of an afferent adds to lag and variance.
    SpikeReplay::Told sensed(std::uint32_t index, SpikeReplay::Told told) const noexcept;
    SpikeReplay::Told sensed_speed(std::uint32_t index, SpikeReplay::Told told) const noexcept;
    struct Bound {
        double force_n, lag_s;
    };
    // Of those that have been silent for longest, the lowest that does not contradict what has just been
    // measured.
    Bound bound(TimePoint until, const ForceBelief& belief) const noexcept;
    void take(const Event& event) noexcept;
    void take_transient(std::uint32_t index, TimePoint time) noexcept;
    void measure(const SpikeReplay::Spike& spike, std::uint32_t index, TimePoint time) noexcept;
    bool outvoted(double force_n, TimePoint time) const noexcept;
    // Brings the belief to `until`: the batch, silence, and time.
    void settle(Progress& progress, TimePoint until) const noexcept;
    // By how much the force is back from its extreme beyond what makes it turn.
    double beyond_turn_n(const Progress& progress) const noexcept;
    void follow_hysteresis(Progress& progress) const noexcept;
    void commit(TimePoint until) noexcept;
    void find_dead() noexcept;
    void unlink(std::uint32_t index) noexcept;
    void link(std::uint32_t index, std::uint32_t before, std::uint32_t after) noexcept;
    void append(std::uint32_t index) noexcept;
    void forgive() noexcept;

    SpikeReplay replay_;
    ForceBelief::Parameters force_;
    ExponentialRate rate_;
    double largest_n_;
    double threshold_n_;  // the lowest
    struct Sensing {
        double largest_n;  // below full scale
        double noise_n, noise_part;
    };
    std::vector<Sensing> sensing_;  // by group
    double hysteresis_;
    double scan_s_;
    Duration history_;
    std::vector<Place> places_;  // the last is the list's head and tail
    std::vector<Heard> heard_;   // by group
    Progress progress_;
    Batch batch_;
    TimePoint measured_;        // when a spike was last measured
    std::uint32_t listed_ = 0;  // in the list
    std::uint32_t sustained_ = 0;
    std::uint32_t speaker_ = SpikeReplay::not_read;    // who told it
    std::uint32_t transient_ = SpikeReplay::not_read;  // that fired last
    TimePoint span_begin_;                             // of the last span
    double surprise_ = 0;                              // the part of the latest spikes that nobody expected
    Estimate last_{};
};

static_assert(Decoder<Filter>);

}  // namespace afferent
