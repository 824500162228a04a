// Decodes events that no scene describes, such as those of a chip: neurons, gains and shares are stated by
// hand. Reads a time in s and an address a line, as embed prints them, and prints the grip force every 50 ms.
#include <afferent/decoders/grip_decoder.hpp>
#include <cstdio>
#include <vector>

using namespace afferent;

// Three elements of a thumb that feel half of the grip together, and one neuron on each.
DecodedAfferents thumb() {
    LifParameters neuron;  // time constants, threshold, reset: those of the chip
    neuron.tau_g_ms = 500;
    neuron.delta_g = 0.03;
    const double gain_mv_per_n = 10.1215;  // from the force on an element to its neuron's drive R·I
    const double bias_mv = 14.4939;
    const double element_full_scale_n = 10;
    const double shares[] = {0.20, 0.18, 0.12};  // of the grip force

    DecodedAfferents afferents;
    afferents.addresses = 9;  // in the stream; those that are not added below are passed over
    afferents.scan = 5ms;     // the sampling period of the sensors
    afferents.tick = 1ns;     // the resolution of an event's time
    afferents.hysteresis = 0.03;
    afferents.largest_grip_n = element_full_scale_n / shares[2];
    for (Address address = 0; address < 3; ++address) {
        const double share = shares[address];
        // All of a group is per newton of grip force, and not of force on the element.
        afferents.add(address,
                      {.neuron = neuron,
                       .drive_mv_per_n = gain_mv_per_n * share,
                       .bias_mv = bias_mv,
                       .full_scale_n = element_full_scale_n / share,
                       .noise_n = 0.01 / share},
                      share);
    }
    // How well that is known: 5 % of each gain and share, unless stated otherwise.
    afferents.uncertainty.gain = 0.03;
    return afferents;
}

int main() {
    GripDecoder decoder = make_decoder(FilterParameters(), thumb());
    TimePoint heard = scene_start;
    std::vector<Event> events;
    double time_s = 0;
    unsigned address = 0;
    while (std::scanf("%lf %u", &time_s, &address) == 2) {
        const TimePoint time = scene_start + rounded(Seconds(time_s));
        // Every span is observed, whether anything fired in it or not: silence is a measurement.
        for (; heard + 50ms <= time; heard += 50ms) {
            decoder.observe(heard, heard + 50ms, events);
            events.clear();
            const Estimate estimate = decoder.estimate(heard + 50ms);
            std::printf("%.3f s: %.2f N, sigma %.2f N, %s\n", seconds(heard + 50ms), estimate.force_n,
                        estimate.sigma_n, name(estimate.doubt));
        }
        events.push_back({time, address});
    }
}
