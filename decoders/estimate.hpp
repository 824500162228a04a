// What a decoder says about the grip force at one time.
#pragma once

namespace afferent {

struct Estimate {
    double force_n = 0;  // grip force
    // One standard deviation: the error of counting whole spikes, and of what has not been heard. It does not
    // cover hysteresis of the sensor or adaptation of the neurons.
    double sigma_n = 0;
    double rate_hz = 0;  // mean over the afferents read

    friend bool operator==(const Estimate&, const Estimate&) = default;
};

}  // namespace afferent
