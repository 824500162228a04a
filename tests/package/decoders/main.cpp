// From address events to the factor on the closing EMG, with nothing but the installed decoders.
#include <afferent/decoders/emg_gain.hpp>
#include <afferent/decoders/force_rate_curve.hpp>
#include <afferent/decoders/spike_rate.hpp>
#include <cstdlib>
#include <vector>

int main() {
    using namespace afferent;
    // 100 Hz from each of three addresses, which the curve below takes for 20 N.
    std::vector<Event> events;
    for (Duration time = 5ms; time < 100ms; time += 10ms)
        for (Address address = 0; address < 3; ++address) events.push_back({scene_start + time, address});
    SpikeRate rate(3, 60ms);
    rate.observe(scene_start, scene_start + 100ms, events);
    rate.advance(scene_start + 100ms);

    const ForceRateCurve curve({{0.3, 1}, {20, 300}});
    const double force_n = curve.force_n(static_cast<double>(rate.events()) / seconds(rate.known()));
    const double gain = EmgGain({.onset_n = 2, .lambda_n = 3, .limit_n = 10})(force_n);
    return force_n > 19 && force_n < 21 && gain == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
