#include "afferent/decoders/inverse_interval.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr Duration memory_of_the_known = 40ms;
// Stands for "no spike yet"; differences to it do not overflow.
constexpr TimePoint long_ago = scene_start - std::chrono::hours(24 * 365 * 100);

double hz(Duration interval) { return 1 / seconds(interval); }

}  // namespace

InverseInterval::InverseInterval(const Parameters& parameters, const DecodedAfferents& afferents)
    : estimator_(GripEstimator::of(afferents, parameters.curve, parameters.pooling)),
      read_(afferents.read()),
      known_(std::vector<bool>(afferents.addresses, false), memory_of_the_known, false),
      trains_(afferents.addresses) {
    restart(scene_start);
}

void InverseInterval::observe(TimePoint begin, TimePoint end, std::span<const Event> events) noexcept {
    if (begin > known_.heard_until()) known_.lose(known_.heard_until(), begin);
    const TimePoint counted_from = known_.snapshot().counted_from;
    for (const Event& event : events) {
        assert(event.address < read_.size());
        if (!read_[event.address] || event.time < counted_from) continue;
        Train& train = trains_[event.address];
        if (train.last >= counted_from && event.time > train.last) {
            const double rate_hz = hz(event.time - train.last);
            train.change_hz = std::abs(rate_hz - train.rate_hz);
            train.rate_hz = rate_hz;
        }
        train.last = event.time;
    }
    known_.observe(begin, end, {});
}

// The rates as the estimator reads them (SpikeCounts): counts in a known second.
class InverseInterval::Rates {
  public:
    Rates(const InverseInterval& decoder, TimePoint now) noexcept : decoder_(&decoder) {
        const ExponentialRate::Snapshot& known = decoder.known_.snapshot();
        counted_from_ = known.counted_from;
        until_ = std::min(now, std::max(known.heard_until, known.presumed_until));
        double squares = 0;
        double afferents = 0;
        for (Address address = 0; address < decoder.read_.size(); ++address) {
            if (!decoder.read_[address]) continue;
            const double rate_hz = events_of(address);
            const Train& train = decoder.trains_[address];
            const double sigma_hz = std::max(train.change_hz, rate_hz < train.rate_hz ? rate_hz / 2 : 0);
            sum_hz_ += rate_hz;
            squares += rate_hz > 0 ? sigma_hz * sigma_hz : 0;
            afferents += 1;
        }
        const ExponentialRate::At at = decoder.known_.at(now);
        if (!(at.window_s() > 0)) return;
        const double part = at.known_s() / seconds(memory_of_the_known);
        // A silent afferent may be about to fire its first spike within the history.
        const double least_hz = hz(decoder.history());
        const double sigma_hz = std::max(std::sqrt(squares / afferents), least_hz) / part;
        window_s_ = std::sqrt(1.0 / 6) / sigma_hz;
    }

    double events() const noexcept { return sum_hz_; }
    double events_of(Address address) const noexcept {
        const Train& train = decoder_->trains_[address];
        const Duration waiting = until_ - std::max(train.last, counted_from_);
        if (!(train.rate_hz > 0) || until_ - train.last >= decoder_->history()) return 0;
        return waiting > 0ns ? std::min(train.rate_hz, hz(waiting)) : train.rate_hz;
    }
    double known_s() const noexcept { return 1; }
    double window_s() const noexcept { return window_s_; }

  private:
    const InverseInterval* decoder_;
    TimePoint counted_from_;
    TimePoint until_;
    double sum_hz_ = 0;
    double window_s_ = 0;
};

Estimate InverseInterval::estimate(TimePoint now) noexcept { return estimator_(Rates(*this, now)); }

void InverseInterval::resume_after(TimePoint start, TimePoint heard_until, const Estimate& last) noexcept {
    known_.resume(start, heard_until);
    std::fill(trains_.begin(), trains_.end(), Train{.last = long_ago});
    estimator_.resume(last);
}

void InverseInterval::resume(const Snapshot& snapshot) {
    require(snapshot.trains.size() == trains_.size(), "snapshot.trains", "one for each address",
            static_cast<double>(snapshot.trains.size()));
    known_.resume(snapshot.known);
    trains_ = snapshot.trains;
    estimator_.resume(snapshot.last);
}

std::size_t InverseInterval::bytes() const noexcept {
    return sizeof(*this) + known_.heap_bytes() + estimator_.heap_bytes() +
           trains_.capacity() * sizeof(Train) + read_.capacity() / 8;
}

}  // namespace afferent
