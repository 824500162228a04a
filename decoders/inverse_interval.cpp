#include "afferent/decoders/inverse_interval.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr Duration memory_of_the_known = 40ms;
// By how much the logarithm of a rate changes from one interval to the next: as under a force that is held,
// but for one interval in twenty, when any change is as likely within a range of e³.
constexpr double held_change = 0.15;
constexpr double range_of_changes = 3;
constexpr double seldom_held = 0.05;

double hz(Duration interval) { return 1 / seconds(interval); }

double likelihood(double change_of_log) {
    const double x = change_of_log / held_change;
    return (1 - seldom_held) * std::exp(-x * x / 2) / (held_change * std::sqrt(2 * std::numbers::pi)) +
           seldom_held / range_of_changes;
}

}  // namespace

InverseInterval::InverseInterval(const Parameters& parameters, const DecodedAfferents& afferents)
    : estimator_(GripEstimator::of(afferents, parameters.curve, parameters.pooling)),
      read_(afferents.read()),
      known_(std::vector<bool>(afferents.addresses, false), memory_of_the_known, false),
      trains_(afferents.addresses),
      tick_s_(seconds(afferents.tick)) {
    restart(scene_start);
}

void InverseInterval::observe(TimePoint begin, TimePoint end, std::span<const Event> events) noexcept {
    if (begin > heard_until()) lose(heard_until(), begin);
    const TimePoint counted_from = known_.snapshot().counted_from;
    for (const Event& event : events) {
        assert(event.address < read_.size());
        if (!read_[event.address] || event.time < counted_from) continue;
        Train& train = trains_[event.address];
        if (train.last != never_fired && event.time > train.last)
            end_interval(train, event.time - train.last);
        train.last = event.time;
        train.lost = lost_;
    }
    known_.observe(begin, end, {});
}

void InverseInterval::end_interval(Train& train, Duration interval) const noexcept {
    double rate_hz = hz(interval);
    double doubt_hz = 0;
    const Duration lost = lost_ - train.lost;
    if (lost > 0ns) {
        const double chance = 2 * rate_hz * seconds(lost);
        if (chance >= 1) return;
        const double change = train.rate_hz > 0 ? std::log(rate_hz / train.rate_hz) : 0;
        // The odds of two intervals to one.
        const double odds =
            chance / (1 - chance) * likelihood(change + std::numbers::ln2) / likelihood(change);
        doubt_hz = rate_hz * std::sqrt(odds) / (1 + odds);
        if (odds > 1) rate_hz *= 2;
    }
    train.change_hz = std::max(std::abs(rate_hz - train.rate_hz), doubt_hz);
    train.rate_hz = rate_hz;
}

// The rates as the estimator reads them (SpikeCounts): counts in a known second.
class InverseInterval::Rates {
  public:
    Rates(const InverseInterval& decoder, TimePoint now) noexcept : decoder_(&decoder) {
        const ExponentialRate::Snapshot& known = decoder.known_.snapshot();
        until_ = std::min(now, std::max(known.heard_until, known.presumed_until));
        double squares = 0;
        for (Address address = 0; address < decoder.read_.size(); ++address) {
            if (!decoder.read_[address]) continue;
            const double rate_hz = events_of(address);
            const Train& train = decoder.trains_[address];
            const double sigma_hz = std::max(train.change_hz, rate_hz < train.rate_hz ? rate_hz / 2 : 0);
            sum_hz_ += rate_hz;
            sum_allowed_hz_ += allowed_hz_of(address);
            squares += rate_hz > 0 ? sigma_hz * sigma_hz : 0;
            afferents_ += 1;
        }
        const ExponentialRate::At at = decoder.known_.at(now);
        if (!(at.window_s() > 0)) return;
        const double part = at.known_s() / seconds(memory_of_the_known);
        // A silent afferent may be about to fire its first spike within the history.
        const double least_hz = hz(decoder.history());
        const double sigma_hz = std::max(std::sqrt(squares / afferents_), least_hz) / part;
        window_s_ = std::sqrt(1.0 / 6) / sigma_hz;
    }

    double events() const noexcept { return sum_hz_; }
    double events_of(Address address) const noexcept {
        const Train& train = decoder_->trains_[address];
        if (!(train.rate_hz > 0) || until_ - train.last >= decoder_->history()) return 0;
        const Duration lost = decoder_->lost_ - train.lost;
        const Duration waiting = until_ - train.last - lost;
        if (waiting <= 0ns) return train.rate_hz;
        if (lost == 0ns) return std::min(train.rate_hz, hz(waiting));
        const double chance = std::min(train.rate_hz * seconds(lost), 1.0);
        return train.rate_hz < 2 * hz(waiting) ? train.rate_hz : (1 + chance) * hz(waiting);
    }
    double known_s() const noexcept { return 1; }
    double window_s() const noexcept { return window_s_; }
    // Both ends of an interval are rounded down to a tick.
    double short_hz(double rate_hz) const noexcept { return rate_hz - 1 / (1 / rate_hz + decoder_->tick_s_); }
    double allowed_hz() const noexcept {
        return sum_allowed_hz_ > 0 ? (sum_hz_ + sum_allowed_hz_) / afferents_ : 0;
    }
    // The rate that an afferent without an interval may have had since the start.
    double allowed_hz_of(Address address) const noexcept {
        const Train& train = decoder_->trains_[address];
        if (train.rate_hz > 0) return 0;
        const Duration unknown = decoder_->lost_;
        const Duration silent = train.last == never_fired
                                    ? until_ - decoder_->start_ - unknown
                                    : std::max(train.last - decoder_->start_ - train.lost,
                                               until_ - train.last - (unknown - train.lost));
        return silent < at_rest_after ? hz(std::max<Duration>(silent, 1us)) : 0;
    }
    // An interval is one, however little is known besides.
    double spike_hz() const noexcept { return 0; }

  private:
    const InverseInterval* decoder_;
    TimePoint until_;
    double sum_hz_ = 0;
    double sum_allowed_hz_ = 0;
    double afferents_ = 0;
    double window_s_ = 0;
};

Estimate InverseInterval::estimate(TimePoint now) noexcept { return estimator_(Rates(*this, now)); }

void InverseInterval::resume_after(TimePoint start, TimePoint heard_until, const Estimate& last) noexcept {
    known_.resume(start, heard_until);
    std::fill(trains_.begin(), trains_.end(), Train{.last = never_fired});
    start_ = start;
    lost_ = {};
    estimator_.resume(last);
}

void InverseInterval::resume(const Snapshot& snapshot) {
    require(snapshot.trains.size() == trains_.size(), "snapshot.trains", "one for each address",
            static_cast<double>(snapshot.trains.size()));
    known_.resume(snapshot.known);
    trains_ = snapshot.trains;
    start_ = snapshot.start;
    lost_ = snapshot.lost;
    estimator_.resume(snapshot.last);
}

std::size_t InverseInterval::bytes() const noexcept {
    return sizeof(*this) + known_.heap_bytes() + estimator_.heap_bytes() +
           trains_.capacity() * sizeof(Train) + read_.capacity() / 8;
}

}  // namespace afferent
