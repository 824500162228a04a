// A decoder that solves each interspike interval for its force, exactly.
#pragma once

#include <vector>

#include "afferent/decoders/decoder.hpp"
#include "afferent/decoders/decoder_parameters.hpp"
#include "afferent/decoders/exponential_rate.hpp"
#include "afferent/decoders/spike_replay.hpp"

namespace afferent {

// The last interval of an afferent tells the force of its last tau_m (interval_drive.hpp). As long as the
// next spike has not come, that bounds the force from above. Once this bound B is below the last force F, the
// force is falling and is estimated as B²/F, so that the estimate goes on falling in silence. The estimate is
// the mean over the afferents, weighted by 1/(tau_m + age)², where age is the time since the last spike: a
// dead afferent has next to no weight, and in a silence of all of them they count alike. Where the bound
// cannot be told from the force at which firing begins, the estimate is 0.
//
// An interval that begins without a spike is solved only if it is longer than five tau_m, because then its
// beginning does not matter. One of which a part was lost is compared with the force that the afferent told
// last, or with the bound if that is lower (spike_replay.hpp).
//
// Saturated: an interval that tells the full scale of its afferent's elements says "at least so much", for as
// long as silence does not bound it below that. It counts as the full scale or, if that is more, as the mean
// of the afferents that can still tell. The estimate is saturated if three quarters of the weight of those
// that are not silent is theirs. Unknown: where nothing is known. Slow: after a start, until each afferent
// either has an interval whose force is known well (SpikeReplay::well_known) or has been silent for longer
// than any force above its threshold would allow. Two sigma cover what its silence allows.
//
// Uncertainty: how far the afferents differ, and by how much each of them has changed since its interval
// before the last, can have fallen since, or is doubted for its ticks and its adaptation. It grows as
// 1/known, as that of ExponentialRate does. Afferents that fire together do not make it smaller.
//
// An event costs one solution of the neuron, and so does an estimate for each afferent. Memory: 76 bytes for
// each afferent and four for each address. Allocates nothing after construction.
class Inversion {
  public:
    using Parameters = InversionParameters;
    // What an afferent has told, beside its state in the replay.
    struct Force {
        double force_n = 0;   // of the last interval that was solved
        double change_n = 0;  // from the one before it
        bool saturated = false;
        bool solved = false;  // an interval since the start has told the force well
        friend bool operator==(const Force&, const Force&) = default;
    };
    struct Snapshot {
        ExponentialRate::Snapshot rate;
        SpikeReplay::Snapshot replay;
        std::vector<Force> forces;
        Estimate last;
        friend bool operator==(const Snapshot&, const Snapshot&) = default;
    };

    // Throws ParameterError: an afferent with a share of the grip force; each of them fires within the range
    // of the sensors.
    Inversion(const Parameters& parameters, const DecodedAfferents& afferents);

    void observe(TimePoint begin, TimePoint end, std::span<const Event> events) noexcept;
    void lose(TimePoint begin, TimePoint end) noexcept;
    void presume_silence(TimePoint until) noexcept { rate_.presume_silence(until); }
    TimePoint heard_until() const noexcept { return rate_.heard_until(); }

    Estimate estimate(TimePoint now) noexcept;
    Duration history() const noexcept { return history_; }

    void restart(TimePoint start) noexcept { resume_after(start, start, {}); }
    void resume_after(TimePoint start, TimePoint heard_until, const Estimate& last) noexcept;
    void correct(const Estimate& last) noexcept { last_ = last; }
    Snapshot snapshot() const { return {rate_.snapshot(), replay_.snapshot(), forces_, last_}; }
    void resume(const Snapshot& snapshot);

    std::size_t bytes() const noexcept;

  private:
    struct Reading {
        double force_n, sigma_n;
        bool saturated;
        bool open;  // it may be any force up to what silence allows
    };
    SpikeReplay::Expected expected(std::uint32_t index, TimePoint until) const noexcept;
    double bound_by_silence(std::uint32_t index, TimePoint until) const noexcept;
    Reading reading_of(std::uint32_t index, TimePoint until) const noexcept;
    // With its weight; not those that are transient.
    template <class F>
    void for_each_reading(TimePoint until, F&& f) const noexcept;

    SpikeReplay replay_;
    double largest_n_;
    std::vector<double> full_scale_n_;  // by afferent
    double full_scale_fraction_;
    Duration history_;
    ExponentialRate rate_;
    std::vector<Force> forces_;  // by afferent
    Estimate last_{};
};

static_assert(Decoder<Inversion>);

}  // namespace afferent
