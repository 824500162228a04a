// From address events to the command of the motor, with nothing but the installed decoders.
#include <afferent/decoders/emg_control.hpp>
#include <afferent/decoders/grip_decoder.hpp>
#include <cstdlib>
#include <vector>

int main() {
    using namespace afferent;
    // Three afferents that begin to fire at 0.3 N and share the grip force.
    const LifParameters neuron;
    DecodedAfferents afferents;
    afferents.addresses = 3;
    afferents.largest_grip_n = 20;
    const DecodedAfferents::Group group{neuron, 2, neuron.rheobase_mv() - 0.3 * 2};
    for (Address address = 0; address < 3; ++address) afferents.add(address, group, 1.0 / 3);

    // The rate that each of them has at 12 N.
    const Duration interval = rounded(Seconds(1 / group.rate_hz(RateKind::steady, 12)));
    std::vector<Event> events;
    for (TimePoint time = scene_start; time < scene_start + 1s; time += interval)
        for (Address address = 0; address < 3; ++address) events.push_back({time, address});

    GripDecoder decoder = make_decoder(SlidingWindowParameters{.window = 500ms}, afferents);
    decoder.observe(scene_start, scene_start + 1s, events);
    const Estimate estimate = decoder.estimate(scene_start + 1s);
    if (estimate.force_n < 11 || estimate.force_n > 13) return EXIT_FAILURE;

    // From 10 N on the hand closes no further.
    const EmgControl control{EmgControl::Parameters()};
    const GripCommand given = control(estimate, GripState::operating, {1, 0.25});
    return given.gain == 0 && given.command == -0.25 ? EXIT_SUCCESS : EXIT_FAILURE;
}
