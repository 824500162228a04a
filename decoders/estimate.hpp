// What a decoder says about the grip force at one time.
#pragma once

namespace afferent {

struct Estimate {
    double force_n = 0;  // grip force
    // One standard deviation: the error of counting whole spikes, or of measuring few intervals, and of what
    // has not been heard. It does not cover hysteresis of the sensor, nor adaptation of the neurons where the
    // decoder does not know it.
    double sigma_n = 0;
    double rate_hz = 0;  // mean over the afferents read

    friend bool operator==(const Estimate&, const Estimate&) = default;
};

}  // namespace afferent
