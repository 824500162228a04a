// A decoder's estimate of the grip force at one time. Included by programs that read estimates.
#pragma once

#include <cstdint>
#include <optional>

namespace afferent {

// Why the grip force may be larger than an estimate and its sigma suggest. If several reasons hold, an
// estimate has the last of this list.
enum class Doubt : std::uint8_t {
    none,
    // The afferents are silent, but at their present rates silence is not yet evidence of a lower force.
    slow,
    // Afferents that would fire at this force have not been heard since the contact began: they are unloaded,
    // or dead.
    unheard,
    // Most of the afferents contradict each other.
    contradicted,
    // No span has been observed for so long that the estimate is stale.
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

// A grip force that is expected, and one standard deviation of it.
struct ExpectedForce {
    double force_n = 0;
    double sigma_n = 0;
    friend bool operator==(const ExpectedForce&, const ExpectedForce&) = default;
};

struct Estimate {
    double force_n = 0;  // grip force
    // One standard deviation. It covers the error of counting whole spikes or of measuring few intervals, and
    // that of spans whose packets are missing. The filter's sigma also covers the systematic errors stated in
    // DecodedAfferents::uncertainty. That of decoders by spike counts does not cover the error by adaptation.
    double sigma_n = 0;
    double rate_hz = 0;  // mean over the afferents read
    // The number of afferents that the decoder ignores at present, because they contradict the others.
    std::uint32_t left_out = 0;
    // The force after FilterParameters::lead, if it goes on rising as it does now; no less than force_n.
    // None: the decoder was not asked for it.
    std::optional<ExpectedForce> coming = {};
    // Unless it is `none`, the EMG gain is computed from the upper bound (emg_gain.hpp).
    Doubt doubt = Doubt::none;

    bool is_lower_bound() const noexcept { return doubt == Doubt::saturated; }

    friend bool operator==(const Estimate&, const Estimate&) = default;
};

}  // namespace afferent
