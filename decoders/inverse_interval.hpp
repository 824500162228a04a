// A decoder that takes the reciprocal of each afferent's last interspike interval as its rate.
#pragma once

#include "afferent/decoders/decoder.hpp"
#include "afferent/decoders/decoder_parameters.hpp"
#include "afferent/decoders/exponential_rate.hpp"
#include "afferent/decoders/grip_estimator.hpp"

namespace afferent {

// The rate of an afferent is 1/T, where T is its last interspike interval or the time since its last spike,
// whichever is longer. It is 0 before the second spike, and after a silence as long as the history. Once
// there are two, it is never too low for want of spikes, and is not doubted as `slow`.
//
// Until an afferent has fired twice since the start, it may have been firing all along at up to the
// reciprocal of its longest silence. Two sigma cover that rate, and the estimate is doubted as `slow`, until
// the second spike or until a silence of `at_rest_after` (silence.hpp).
//
// Where a span within an interval is lost, a spike may have been lost with it. The interval is taken as one
// or as two, whichever is likelier: by how often such a span holds a spike, and by how far the rate would
// change from the interval before. Where so much is lost that it holds spikes for sure, the interval does not
// count, and the one before it stands. A silence in which something was lost lowers the rate only once it is
// too long for two intervals; lost time does not count.
//
// Uncertainty. Under a held force the intervals are equal, but for adaptation. So the standard deviation of a
// rate is its change from the interval before, or half of the rate while the next spike is overdue; the root
// mean square over all afferents is taken for each of them. It grows as 1/known, as that of ExponentialRate.
//
// An estimate costs O(addresses). Memory: 32 bytes for each address, plus the curves (some 350 points each).
// Allocates nothing after construction, at any rate of events.
class InverseInterval {
  public:
    using Parameters = InverseIntervalParameters;
    struct Train {
        TimePoint last;        // spike
        double rate_hz = 0;    // of the last interval
        double change_hz = 0;  // from the interval before it
        Duration lost{};       // of all time until the last spike
        friend bool operator==(const Train&, const Train&) = default;
    };
    struct Snapshot {
        ExponentialRate::Snapshot known;
        std::vector<Train> trains;  // by address
        TimePoint start;
        Duration lost;  // of all time since the start
        Estimate last;
        friend bool operator==(const Snapshot&, const Snapshot&) = default;
    };

    // Throws ParameterError: an afferent with a share of the grip force; each of them fires within the range
    // of the sensors.
    InverseInterval(const Parameters& parameters, const DecodedAfferents& afferents);

    void observe(TimePoint begin, TimePoint end, std::span<const Event> events) noexcept;
    void lose(TimePoint begin, TimePoint end) noexcept {
        known_.lose(begin, end);
        lost_ += std::max<Duration>(end - begin, 0ns);
    }
    void presume_silence(TimePoint until) noexcept { known_.presume_silence(until); }
    TimePoint heard_until() const noexcept { return known_.heard_until(); }

    Estimate estimate(TimePoint now) noexcept;
    // e^−40 is less than half a unit in the last place of 1.
    Duration history() const noexcept { return 40 * known_.time_constant(); }

    void restart(TimePoint start) noexcept { resume_after(start, start, {}); }
    void resume_after(TimePoint start, TimePoint heard_until, const Estimate& last) noexcept;
    void correct(const Estimate& last) noexcept { estimator_.resume(last); }
    Snapshot snapshot() const { return {known_.snapshot(), trains_, start_, lost_, estimator_.last()}; }
    void resume(const Snapshot& snapshot);

    std::size_t bytes() const noexcept;

  private:
    class Rates;
    void end_interval(Train& train, Duration interval) const noexcept;

    GripEstimator estimator_;  // checks the afferents
    std::vector<bool> read_;
    ExponentialRate known_;  // counts no spikes, only how much is known
    std::vector<Train> trains_;
    double tick_s_;
    TimePoint start_ = scene_start;
    Duration lost_{};
};

static_assert(Decoder<InverseInterval>);

}  // namespace afferent
