// The paper's decoder: spikes counted in a sliding window, through the neurons' force–rate curve.
#pragma once

#include "afferent/decoders/decoder.hpp"
#include "afferent/decoders/decoder_parameters.hpp"
#include "afferent/decoders/grip_estimator.hpp"
#include "afferent/decoders/spike_rate.hpp"

namespace afferent {

// A window is empty between two spikes of an afferent that fires less than once in its length. What that
// silence allows is in the upper bound (silence.hpp).
//
// Memory: 8 bytes for each address, 16 bytes for each event of the busiest window so far, or of one at 500 Hz
// from each address if that is more, and the curves (some 350 points each). Allocates nothing after
// construction up to that rate and 64 unknown spans in the window.
class SlidingWindow {
  public:
    using Parameters = SlidingWindowParameters;
    struct Snapshot {
        SpikeRate::Snapshot rate;
        Estimate last;
        friend bool operator==(const Snapshot&, const Snapshot&) = default;
    };

    // Throws ParameterError: window > 0; an afferent with a share of the grip force; each of them fires
    // within the range of the sensors.
    SlidingWindow(const Parameters& parameters, const DecodedAfferents& afferents);

    void observe(TimePoint begin, TimePoint end, std::span<const Event> events) {
        rate_.observe(begin, end, events);
    }
    void lose(TimePoint begin, TimePoint end) { rate_.lose(begin, end); }
    void presume_silence(TimePoint until) noexcept { rate_.presume_silence(until); }
    TimePoint heard_until() const noexcept { return rate_.heard_until(); }

    Estimate estimate(TimePoint now) noexcept;
    Duration history() const noexcept { return std::max(rate_.window(), at_rest_after); }

    void restart(TimePoint start) { resume_after(start, start, {}); }
    void resume_after(TimePoint start, TimePoint heard_until, const Estimate& last);
    void correct(const Estimate& last) noexcept { estimator_.resume(last); }
    Snapshot snapshot() const { return {rate_.snapshot(), estimator_.last()}; }
    void resume(const Snapshot& snapshot);

    std::size_t bytes() const noexcept;

  private:
    GripEstimator estimator_;  // checks the afferents
    SpikeRate rate_;
};

static_assert(Decoder<SlidingWindow>);

}  // namespace afferent
