// A decoder that weighs spikes by an exponential kernel and inverts the neurons' force–rate curve.
#pragma once

#include "afferent/decoders/decoder.hpp"
#include "afferent/decoders/decoder_parameters.hpp"
#include "afferent/decoders/exponential_rate.hpp"
#include "afferent/decoders/grip_estimator.hpp"

namespace afferent {

// An estimate costs O(1) if pooled and O(neurons) if per neuron. Memory: at most 16 bytes for each address,
// plus the curves (some 350 points each). Allocates nothing after construction, at any rate of events.
class Exponential {
  public:
    using Parameters = ExponentialParameters;
    struct Snapshot {
        ExponentialRate::Snapshot rate;
        Estimate last;
        friend bool operator==(const Snapshot&, const Snapshot&) = default;
    };

    // Throws ParameterError: time_constant > 0; an afferent with a share of the grip force; each of them
    // fires within the range of the sensors.
    Exponential(const Parameters& parameters, const DecodedAfferents& afferents);

    void observe(TimePoint begin, TimePoint end, std::span<const Event> events) noexcept {
        rate_.observe(begin, end, events);
    }
    void lose(TimePoint begin, TimePoint end) noexcept { rate_.lose(begin, end); }
    void presume_silence(TimePoint until) noexcept { rate_.presume_silence(until); }
    TimePoint heard_until() const noexcept { return rate_.heard_until(); }

    Estimate estimate(TimePoint now) noexcept { return estimator_(rate_.at(now)); }
    // e^−40 is less than half a unit in the last place of 1.
    Duration history() const noexcept {
        return std::max<Duration>(40 * rate_.time_constant(), at_rest_after);
    }

    void restart(TimePoint start) noexcept { resume_after(start, start, {}); }
    void resume_after(TimePoint start, TimePoint heard_until, const Estimate& last) noexcept;
    void correct(const Estimate& last) noexcept { estimator_.resume(last); }
    Snapshot snapshot() const { return {rate_.snapshot(), estimator_.last()}; }
    void resume(const Snapshot& snapshot);

    std::size_t bytes() const noexcept;

  private:
    GripEstimator estimator_;  // checks the afferents
    ExponentialRate rate_;
};

static_assert(Decoder<Exponential>);

}  // namespace afferent
