#include "afferent/decoders/spike_rate.hpp"

#include <algorithm>
#include <cassert>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// As many events as a window holds at 500 Hz from each address.
std::size_t expected_events(std::size_t addresses, Duration window) {
    return std::max<std::size_t>(1024, static_cast<std::size_t>(500 * seconds(window)) * addresses);
}

}  // namespace

SpikeRate::SpikeRate(std::vector<bool> read, Duration window)
    : read_(std::move(read)),
      window_(window),
      events_(expected_events(read_.size(), window)),
      unknown_(64),
      counts_(read_.size(), 0),
      last_of_(read_.size(), never_fired) {
    require(window > 0ns, "window_ms", "> 0", Milliseconds(window).count());
}

void SpikeRate::observe(TimePoint begin, TimePoint end, std::span<const Event> events) {
    if (begin > heard_until_) lose(heard_until_, begin);
    for (const Event& event : events) {
        assert(event.address < read_.size());
        if (!read_[event.address]) continue;
        events_.append(event);
        ++counts_[event.address];
        last_of_[event.address] = std::max(last_of_[event.address], event.time);
        last_ = std::max(last_, event.time);
    }
    heard_until_ = std::max(heard_until_, end);
}

void SpikeRate::lose(TimePoint begin, TimePoint end) {
    if (begin >= end) return;
    if (!unknown_.empty() && unknown_.back().end == begin)
        unknown_.back().end = end;
    else
        unknown_.append(Span{begin, end});
    lost_until_ = std::max(lost_until_, end);
    heard_until_ = std::max(heard_until_, end);
}

void SpikeRate::advance(TimePoint now) {
    now_ = now;
    const TimePoint begin = now_ - window_;
    while (!events_.empty() && events_.front().time <= begin) {
        --counts_[events_.front().address];
        events_.pop_front();
    }
    while (!unknown_.empty() && unknown_.front().end <= begin) unknown_.pop_front();
}

void SpikeRate::resume(TimePoint start, TimePoint heard_until) {
    events_.clear();
    unknown_.clear();
    std::fill(counts_.begin(), counts_.end(), 0);
    std::fill(last_of_.begin(), last_of_.end(), never_fired);
    last_ = never_fired;
    lost_until_ = now_ = start_ = start;
    heard_until_ = presumed_until_ = heard_until;
}

SpikeRate::Snapshot SpikeRate::snapshot() const {
    return {.now = now_,
            .start = start_,
            .heard_until = heard_until_,
            .presumed_until = presumed_until_,
            .events = {events_.begin(), events_.end()},
            .unknown = {unknown_.begin(), unknown_.end()},
            .lost_until = lost_until_,
            .last_of = last_of_};
}

void SpikeRate::resume(const Snapshot& snapshot) {
    require(snapshot.last_of.size() == last_of_.size(), "snapshot.last_of", "one for each address",
            static_cast<double>(snapshot.last_of.size()));
    for (const Event& event : snapshot.events)
        require(event.address < read_.size() && read_[event.address], "snapshot.address", "one that is read",
                event.address);
    resume(snapshot.start, snapshot.heard_until);
    now_ = snapshot.now;
    presumed_until_ = snapshot.presumed_until;
    for (const Event& event : snapshot.events) {
        events_.append(event);
        ++counts_[event.address];
    }
    for (const Span& span : snapshot.unknown) unknown_.append(span);
    lost_until_ = snapshot.lost_until;
    last_of_ = snapshot.last_of;
    for (const TimePoint last : last_of_) last_ = std::max(last_, last);
}

std::size_t SpikeRate::heap_bytes() const noexcept {
    return events_.capacity() * sizeof(Event) + unknown_.capacity() * sizeof(Span) +
           counts_.capacity() * sizeof(std::uint32_t) + last_of_.capacity() * sizeof(TimePoint) +
           read_.capacity() / 8;
}

Duration SpikeRate::known() const noexcept {
    const TimePoint begin = std::max(now_ - window_, start_);
    const TimePoint end = known_until();
    Duration known = std::max(end - begin, 0ns);
    for (const Span& span : unknown_)
        known -= std::max(std::min(span.end, end) - std::max(span.begin, begin), Duration(0));
    return known;
}

}  // namespace afferent
