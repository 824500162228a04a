// What a decoder says about the grip force at one time.
#pragma once

#include <cstdint>

namespace afferent {

struct Estimate {
    double force_n = 0;  // grip force
    // One standard deviation: the error of counting whole spikes, or of measuring few intervals, and of what
    // has not been heard. Only the filter's covers the sensor's hysteresis, and the decoders that count
    // spikes know nothing of adaptation.
    double sigma_n = 0;
    double rate_hz = 0;  // mean over the afferents read
    // Afferents that do not count at present, because they contradict the others.
    std::uint32_t left_out = 0;

    friend bool operator==(const Estimate&, const Estimate&) = default;
};

}  // namespace afferent
