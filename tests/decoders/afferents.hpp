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

// Spikes every `interval` from `first` on, before `end`.
inline std::vector<Event> regular_train(Address address, Duration first, Duration interval, Duration end) {
    std::vector<Event> events;
    for (Duration time = first; time < end; time += interval) events.push_back({at(time), address});
    return events;
}

}  // namespace afferent
