// A decoder that keeps a belief of the grip force, which spikes and silence correct.
//
// What it consists of, in the order in which a spike meets them:
//   spike_replay.hpp       what a spike or a silence says of the force, given the adaptation
//   afferent_roster.hpp    who is listened to
//   force_belief.hpp       the force, its rate of change, and each element's departure from its share
//   hysteresis_branch.hpp  from the sensed force to the grip force
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "afferent/decoders/afferent_roster.hpp"
#include "afferent/decoders/decoder.hpp"
#include "afferent/decoders/decoder_parameters.hpp"
#include "afferent/decoders/exponential_rate.hpp"
#include "afferent/decoders/force_belief.hpp"
#include "afferent/decoders/hysteresis_branch.hpp"
#include "afferent/decoders/spike_replay.hpp"

namespace afferent {

// A spike is a linear measurement of the force on its element: the mean over the last tau_m or so of the
// interval, exact but for the tick of its stamp and for what is not known of the adaptation
// (spike_replay.hpp). Silence bounds the same mean from above, and a spike at full scale bounds it from
// below. The grip force, its rate and how far each element departs from its share of the force are the state
// of ForceBelief, so that a gain or a share that is not as stated is neither averaged away nor taken for a
// change of the force.
//
// A single afferent fires when this bound has come down to the force, so that the force falls more slowly
// than the bound. Several afferents know the speed better from each other's spikes.
//
// A spike of a transient afferent measures the size of the force's rate of change, and the silence of the one
// that fired last bounds it. What is lost is neither: it widens the belief.
//
// Who is not listened to, and until when:
//   rejected  Most others contradict its spikes time and again. Readmitted when they agree, and every minute.
//             A departure within Uncertainty is no contradiction.
//   dead      It is silent for 100 ms at a force at which it would have fired. Readmitted when it fires.
//   unheard   As dead, but its whole patch has been silent since the contact began and may be unloaded. The
//             estimate is that of an unloaded patch, whose load the others carry; the upper bound is that of
//             a dead one (Doubt::unheard).
//
// Sigma contains what DecodedAfferents::uncertainty says, and grows where predictions have been worse than
// their own sigma. An estimate at rest, below the force at which firing begins, is 0, as silence says no
// more.
//
// Forces are believed in units of the afferents' range, so that the same hand in another unit, or ten times
// as strong, is decoded alike.
//
// An event costs O(1), and so does an estimate; both cost the square of the number of elements, of which at
// most 32 are told apart: more are taken together in 16 blocks of neighbours. Memory: 100 bytes for each
// afferent, four for each address, 37 kB for each ratio of time constants, and for the belief 40 kB with nine
// elements and 370 kB with 32.
// Allocates nothing after construction.
class Filter {
  public:
    using Motion = FilterMotion;
    using Parameters = FilterParameters;
    // The belief, and the time of which it is.
    struct Progress {
        ForceBelief belief;
        TimePoint time;
        HysteresisBranch branch;
        // The mean square of what the latest innovations were in standard deviations; 1 where sigma is right.
        double innovation = 1;
        double wander = 1;         // how much more strongly the shares wander than stated
        double squared_speed = 0;  // of the force, of late
        friend bool operator==(const Progress&, const Progress&) = default;
    };
    // The spikes of an element within three milliseconds, weighed by 1/variance; not yet in the belief, which
    // is that of their begin.
    struct Batch {
        double weight = 0;
        double force = 0;    // weighed
        double lag = 0;      // weighed, from the begin
        double least_n = 0;  // where a spike was one of full scale
        double least_lag_s = 0;
        double falls_n_per_s = std::numeric_limits<double>::infinity();  // F falls no faster
        friend bool operator==(const Batch&, const Batch&) = default;
    };
    // The last interval that a spike of a group has measured.
    struct Measured {
        TimePoint begin, end;
        std::uint32_t element;
        friend bool operator==(const Measured&, const Measured&) = default;
    };
    struct Snapshot {
        ExponentialRate::Snapshot rate;
        SpikeReplay::Snapshot replay;
        AfferentRoster::Snapshot roster;
        std::vector<TimePoint> patch_fired;
        std::vector<Measured> measured;
        std::vector<Batch> batches;
        TimePoint batch_begin;
        std::uint32_t batched;
        Progress progress;
        TimePoint measured_at, searched_at, contact_since, span_begin;
        SpikeReplay::Losses::Span lost;
        std::uint32_t transient, speaker, odd_afferents, rejected;
        TimePoint contradicted_at;
        double conflict, objection, contradicted_n, adaptation_n, unheard_share;
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

    // Whether an afferent is not listened to at present: rejected or dead.
    bool left_out(Address address) const noexcept;

  private:
    // The elements whose departures the belief tells apart, and the element of each afferent.
    struct Elements {
        Elements(const SpikeReplay& replay, const DecodedAfferents& afferents);
        std::size_t heap_bytes() const noexcept {
            return (element.capacity() + patch.capacity()) * sizeof(std::uint32_t) +
                   (share.capacity() + spread.share.capacity()) * sizeof(double);
        }

        ElementSpread spread;
        std::vector<std::uint32_t> element{}, patch{};  // by afferent
        std::vector<double> share{};                    // by afferent, of the shares of all
        double unresolved_variance =
            0;                       // of an afferent's departure from its block's, as a part of the force
        double common_variance = 0;  // of the mean gain, which is in no element's state
    };
    struct Sensing {
        double full_scale_n;  // from which on a spike says no more than "at least so much"
        double noise_n, noise_fraction;
    };
    // What a spike or a silence of an afferent says, with what sampling by its sensor adds.
    SpikeReplay::Measurement sensed(std::uint32_t index, SpikeReplay::Measurement measured) const noexcept;
    SpikeReplay::Measurement sensed_speed(std::uint32_t index,
                                          SpikeReplay::Measurement measured) const noexcept;
    ForceBelief::View view(std::uint32_t index, double lag_s) const noexcept {
        return {lag_s, elements_.element[index]};
    }

    // A bound by silence: of what the element reads, and of the grip. Whether its element has departed from
    // its share for it, and whether by more than is normal.
    struct Silence {
        double bound_n, lag_s;
        double grip_n;
        bool departs, contradicts;
    };
    std::optional<Silence> silence_of(std::uint32_t index, TimePoint until,
                                      const Progress& progress) const noexcept;
    double reading_of(std::uint32_t index, const ForceBelief& belief) const noexcept;
    double normal_departure(const Progress& progress) const noexcept;
    void take_silence(Progress& progress, TimePoint until) const noexcept;
    static void follow_innovation(Progress& progress, double squared) noexcept;
    void find_silent(std::uint8_t steps) noexcept;
    void list_unheard() noexcept;
    std::uint32_t unheard() const noexcept;

    // Brings the belief to `until`: applies the batches, silence, and the passing of time.
    void settle(Progress& progress, TimePoint until) const noexcept;
    void commit(TimePoint until) noexcept;
    void clear_batches() noexcept;
    void start_afresh() noexcept;

    void take(const Event& event) noexcept;
    void take_transient(std::uint32_t index, TimePoint time) noexcept;
    bool is_repeated(const SpikeReplay::Spike& spike, std::uint32_t index, TimePoint time) noexcept;
    void measure(const SpikeReplay::Spike& spike, std::uint32_t index, TimePoint time) noexcept;
    bool counts(std::uint32_t index, double force_n, double variance_n2, const ForceBelief::View& seen,
                TimePoint time) noexcept;
    void object(double force_n, double lag_s, TimePoint time) noexcept;
    bool judge(std::uint32_t index, bool odd, bool contradicted) noexcept;
    bool can_depart() const noexcept;
    bool is_contradicted(std::uint32_t index, double force_n, double expected_n, bool odd,
                         TimePoint time) const noexcept;
    bool is_agreed() const noexcept;
    void listen_to(std::uint32_t index) noexcept;
    void leave_out(std::uint32_t index, AfferentRoster::Standing standing) noexcept;

    bool is_saturated(TimePoint until) const noexcept;
    double silent_below_n(const Progress& progress, TimePoint until) const noexcept;
    double departed(const ForceBelief& belief) const noexcept;
    void look_ahead(TimePoint until, TimePoint time, bool is_lost) noexcept;
    void convert_ahead(double passed_s, TimePoint until) noexcept;

    // What estimates at `time` and shortly after it start from: it follows from the state that a snapshot
    // has.
    struct Ahead {
        Progress progress;
        TimePoint until{}, time{};
        double silent_n = 0;
        bool is_lost = false, is_saturated = false, known = false;
    };

    double unit_n_;  // newtons of grip; the unit of all forces below and of the parts' states
    SpikeReplay replay_;
    Elements elements_;
    Uncertainty uncertainty_;
    ExponentialRate rate_;
    double delay_s_;
    double lead_s_;
    double largest_n_;
    double threshold_n_;              // the lowest
    double full_scale_fraction_;      // of a full scale, from which on a reading is one of full scale
    double offset_n_ = 0;             // sigma of the grip force by the elements' zeros
    std::vector<Sensing> sensing_{};  // by group
    double scan_s_;
    Duration history_{};
    std::uint32_t sustained_ = 0;
    Progress unknown_;  // where nothing is known

    AfferentRoster roster_;
    std::vector<TimePoint> patch_fired_{};
    std::vector<Measured> measured_;  // by group
    std::vector<Batch> batches_;      // by element, or one
    TimePoint batch_begin_;
    std::uint32_t batched_ = 0;  // batches that are not empty
    Progress progress_;
    Ahead ahead_;
    TimePoint measured_at_;                            // when a spike was last measured
    TimePoint searched_at_;                            // when silent ones were last looked for
    TimePoint contact_since_;                          // when the force was last at rest
    TimePoint span_begin_;                             // of the last span
    SpikeReplay::Losses::Span lost_{};                 // the last
    std::uint32_t transient_ = SpikeReplay::not_read;  // that fired last
    std::uint32_t speaker_ = SpikeReplay::not_read;    // of the sustained ones, that fired last
    std::uint32_t odd_afferents_ = 0;                  // how many have contradicted others lately
    std::uint32_t rejected_ = 0;
    TimePoint contradicted_at_;  // when a spike did so last
    double objection_ = 0;       // the part of the latest spikes that departed too far to be normal
    double conflict_ = 0;        // the part of the latest spikes that contradicted most others
    double contradicted_n_ = 0;  // what the last of those said
    double adaptation_n_ = 0;    // how much of the latest measurements was the adaptation's
    double unheard_share_ = 0;   // of the grip force, by what is stated
    Estimate last_{};
};

static_assert(Decoder<Filter>);

}  // namespace afferent
