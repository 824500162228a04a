// What a decoder says about the grip force at one time.
#pragma once

#include <cstdint>

namespace afferent {

// Why the grip force may be larger than an estimate and its sigma suggest. Where several reasons hold, an
// estimate has the last of them in this list.
enum class Doubt : std::uint8_t {
    none,
    // The afferents are silent, and at the rates at which they fire now they might be silent all the same.
    slow,
    // Afferents that would fire at this force have not been heard since the contact began: they are unloaded,
    // or dead.
    unheard,
    // Most of the afferents contradict each other.
    contradicted,
    // Nothing has been known for so long that the estimate is an old one.
    unknown,
    // The afferents' elements are at full scale: the estimate is a lower bound.
    saturated,
};

inline constexpr Doubt last_doubt = Doubt::saturated;

constexpr const char* name(Doubt doubt) noexcept {
    switch (doubt) {
        case Doubt::none:
            return "none";
        case Doubt::slow:
            return "slow";
        case Doubt::unheard:
            return "unheard";
        case Doubt::contradicted:
            return "contradicted";
        case Doubt::unknown:
            return "unknown";
        case Doubt::saturated:
            return "saturated";
    }
    return "none";
}

struct Estimate {
    double force_n = 0;  // grip force
    // One standard deviation. It covers the error of counting whole spikes or of measuring few intervals, and
    // that of spans whose packets have not come. The filter's also covers what DecodedAfferents::uncertainty
    // says is not known. Decoders that count spikes leave the error by adaptation out.
    double sigma_n = 0;
    double rate_hz = 0;  // mean over the afferents read
    // Afferents that the decoder ignores at present, because they contradict the others.
    std::uint32_t left_out = 0;
    // Unless it is `none`, the EMG gain goes by the upper bound (emg_gain.hpp).
    Doubt doubt = Doubt::none;

    bool is_lower_bound() const noexcept { return doubt == Doubt::saturated; }

    friend bool operator==(const Estimate&, const Estimate&) = default;
};

}  // namespace afferent
