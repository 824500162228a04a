// What a decoder says about the grip force at one time.
#pragma once

#include <cstdint>

namespace afferent {

struct Estimate {
    double force_n = 0;  // grip force
    // One standard deviation. It covers the error of counting whole spikes or of measuring few intervals, and
    // that of spans whose packets have not come. Only the filter's covers the sensor's hysteresis, and
    // decoders that count spikes leave the error by adaptation out.
    double sigma_n = 0;
    double rate_hz = 0;  // mean over the afferents read
    // Afferents that the decoder ignores at present, because they contradict the others.
    std::uint32_t left_out = 0;

    friend bool operator==(const Estimate&, const Estimate&) = default;
};

}  // namespace afferent
