// Afferents and streams of events to test decoders with.
#pragma once

#include <algorithm>
#include <random>
#include <vector>

#include "afferent/decoders/decoded_afferents.hpp"
#include "afferent/decoders/estimate.hpp"
#include "afferent/neurons/models.hpp"
#include "tests/since_start.hpp"

namespace afferent {

// Begins to fire at 0.3 N.
inline DecodedAfferents::Group group_with(double drive_mv_per_n) {
    const LifParameters neuron;
    return {neuron, drive_mv_per_n, neuron.rheobase_mv() - 0.3 * drive_mv_per_n};
}

// Five addresses: 0, 1 and 3 are read and have shares of 1/4, 1/4 and 1/2; 4 is read and has none.
inline DecodedAfferents fingertips() {
    DecodedAfferents afferents{.addresses = 5, .largest_grip_n = 20};
    afferents.add(0, group_with(2), 0.25);
    afferents.add(1, group_with(2), 0.25);
    afferents.add(3, group_with(4), 0.5);
    afferents.add(4, group_with(0), 0);
    return afferents;
}

// One step of a stream: a span that is observed or lost, then an estimate.
struct Step {
    TimePoint begin, end;
    bool lost;
    std::vector<Event> events;
    TimePoint presumed;
    TimePoint now;
};

// Spans of 1 to 10 ms; every fifth is lost, every tenth missing. Some 50 Hz from each address.
inline std::vector<Step> random_stream(unsigned seed, int steps, std::size_t addresses) {
    std::mt19937 random(seed);
    const auto below = [&](unsigned n) { return static_cast<std::int64_t>(random() % n); };
    std::vector<Step> stream;
    TimePoint end = scene_start;
    TimePoint now = scene_start;
    while (stream.size() < static_cast<std::size_t>(steps)) {
        Step step{.begin = end,
                  .end = end + Duration(1'000'000 + below(9'000'000)),
                  .lost = below(5) == 0,
                  .events = {},
                  .presumed = {},
                  .now = {}};
        end = step.end;
        const auto length_ns = static_cast<unsigned>((step.end - step.begin).count());
        if (!step.lost)
            for (Address address = 0; address < addresses; ++address)
                if (below(1'000'000'000 / 50) < length_ns)
                    step.events.push_back({step.begin + Duration(below(length_ns)), address});
        std::sort(step.events.begin(), step.events.end());
        now = std::max(now, step.end + Duration(below(8'000'000)));
        step.now = now;
        step.presumed = std::min(now, step.end + Duration(below(4'000'000)));
        if (below(10) != 0) stream.push_back(std::move(step));
    }
    return stream;
}

template <class D>
Estimate take(D& decoder, const Step& step) {
    if (step.lost)
        decoder.lose(step.begin, step.end);
    else
        decoder.observe(step.begin, step.end, step.events);
    decoder.presume_silence(step.presumed);
    return decoder.estimate(step.now);
}

// The spikes of the group's neuron under a force that is constant for each millisecond.
template <class Force>
std::vector<Event> fired(const DecodedAfferents::Group& group, Duration end, Force force_n,
                         Address address = 0) {
    return visit_neuron(group.neuron, [&]<class N>(const N& neuron) {
        std::vector<Event> events;
        typename N::State state = neuron.rest();
        for (Duration begin = 0ms; begin < end; begin += 1ms) {
            const double drive_mv = group.drive_mv_per_n * force_n(seconds(begin)) + group.bias_mv;
            Interval left = 1ms;
            for (Interval next; (next = neuron.next_spike(state, drive_mv)) < left; left -= next) {
                neuron.advance(state, drive_mv, next);
                neuron.fire(state);
                events.push_back({at(begin + 1ms - rounded(left - next)), address});
            }
            neuron.advance(state, drive_mv, left);
        }
        return events;
    });
}

// Spans of 5 ms of what afferents fire under a force; every tenth is lost.
template <class Force>
std::vector<Step> stream_under(const DecodedAfferents& afferents, Duration end, Force force_n) {
    std::vector<Event> events;
    for (const auto& [address, group, share, patch] : afferents.afferents) {
        if (share == 0) continue;
        const auto own = fired(afferents.groups[group], end, force_n, address);
        events.insert(events.end(), own.begin(), own.end());
    }
    std::sort(events.begin(), events.end());
    std::vector<Step> stream;
    auto next = events.begin();
    for (Duration begin = 0ms; begin < end; begin += 5ms) {
        Step step{.begin = at(begin),
                  .end = at(begin + 5ms),
                  .lost = stream.size() % 10 == 7,
                  .events = {},
                  .presumed = at(begin + 5ms),
                  .now = at(begin + 7ms)};
        for (; next != events.end() && next->time < step.end; ++next)
            if (!step.lost) step.events.push_back(*next);
        stream.push_back(std::move(step));
    }
    return stream;
}

// Spikes every `interval` from `first` on, before `end`.
inline std::vector<Event> regular_train(Address address, Duration first, Duration interval, Duration end) {
    std::vector<Event> events;
    for (Duration time = first; time < end; time += interval) events.push_back({at(time), address});
    return events;
}

// Elements of one full scale, each with an afferent, that share the grip force. At full scale an adapted
// afferent fires at some 190 Hz.
inline DecodedAfferents sensors(double full_scale_n, const std::vector<double>& shares) {
    DecodedAfferents decoded{.addresses = shares.size(), .tick = 100us};
    const double mv_per_n = 40 / full_scale_n;
    for (Address i = 0; i < shares.size(); ++i) {
        DecodedAfferents::Group group = group_with(mv_per_n);
        group.drive_mv_per_n *= shares[i];
        group.full_scale_n = full_scale_n / shares[i];
        decoded.add(i, group, shares[i]);
        decoded.largest_grip_n = std::max(decoded.largest_grip_n, group.full_scale_n);
    }
    return decoded;
}

inline std::vector<double> shares_of_nine() { return {0.20, 0.18, 0.12, 0.11, 0.10, 0.06, 0.10, 0.08, 0.05}; }

// The spikes of afferents under a grip force; no element feels more than its full scale.
template <class Force>
std::vector<Event> pressed(const DecodedAfferents& decoded, Duration end, Force force_n) {
    std::vector<Event> events;
    for (const auto& [address, index, share, patch] : decoded.afferents) {
        const DecodedAfferents::Group& group = decoded.groups[index];
        const auto felt_n = [&](double time_s) { return std::min(force_n(time_s), group.full_scale_n); };
        const auto train = fired(group, end, felt_n, address);
        events.insert(events.end(), train.begin(), train.end());
    }
    for (Event& event : events) event.time -= (event.time - scene_start) % decoded.tick;
    std::sort(events.begin(), events.end());
    return events;
}

// The estimates after packets of 5 ms, of which those are lost that `is_lost` says.
template <class D, class IsLost>
std::vector<Estimate> estimates(D& decoder, const std::vector<Event>& events, Duration end, IsLost is_lost) {
    std::vector<Estimate> all;
    auto first = events.begin();
    for (Duration begin = 0ms; begin < end; begin += 5ms) {
        const auto last = std::find_if(first, events.end(),
                                       [&](const Event& event) { return event.time >= at(begin + 5ms); });
        if (is_lost())
            decoder.lose(at(begin), at(begin + 5ms));
        else
            decoder.observe(at(begin), at(begin + 5ms), {first, last});
        first = last;
        all.push_back(decoder.estimate(at(begin + 5ms)));
    }
    return all;
}

template <class D>
std::vector<Estimate> estimates(D& decoder, const std::vector<Event>& events, Duration end) {
    return estimates(decoder, events, end, [] { return false; });
}

}  // namespace afferent
