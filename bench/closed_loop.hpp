// Question: does the gain keep a grip force at its limit? Random closed loops of a simulated hand, in which
// the sensors and the decoder's description of them are drawn separately.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "afferent/decoders/gain_reach.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// A scene, and how the real hand differs from it.
struct ClosedLoop {
    Scene told;  // accepts an unreachable limit, so that it can always be planned
    // The error by which the scene is refused if it does not accept that; empty if it is not refused.
    std::string refusal;
    // What the scene says wrongly: "nothing", "gains", "shares", "tau_g", "dead" or "hysteresis".
    std::string wrong;
    std::vector<double> gains;  // by element, as factors on the told gains
    std::vector<std::uint32_t> dead;
    double tau_g = 1;       // a factor
    double hysteresis = 0;  // of the sensors
};

// The loop with this index among those of a seed. It does not depend on the others.
ClosedLoop draw_closed_loop(std::uint64_t seed, std::uint64_t index);

struct ClosedLoopResult {
    std::string decoder;
    std::uint32_t elements;
    double limit_n;
    // The grip force at which the last element is at its full scale.
    double full_scale_n;
    // The numbers by which the scene's check decides.
    GainReach reach;
    // The grip force at which the real sensors read as the told ones do at the limit; at most 1.5 times the
    // limit.
    double told_limit_n;
    double peak_n;
    // The largest force of a hand whose command ends as soon as sensors, link and envelope can report that
    // the force has passed told_limit_n.
    double momentum_n;
    // How long the force was more than 1 N above momentum_n with the gain open.
    double above_s;

    // Whether the force exceeded what momentum explains for longer than a tenth of a second.
    bool bad() const noexcept { return above_s > 0.1; }
    // Whether the sensors end below the limit, cover it with less than 30 % to spare, or with more.
    const char* coverage() const noexcept;
};

ClosedLoopResult run_closed_loop(const ClosedLoop& loop);

struct ClosedLoopRow {
    ClosedLoop loop;
    ClosedLoopResult result;
};

// The first `count` loops, on all processors. `progress` is told the fraction that is done, from one thread
// at a time.
std::vector<ClosedLoopRow> search_closed_loops(std::uint64_t seed, std::uint64_t count,
                                               const std::function<void(double)>& progress);

// closed_loop.csv. Throws std::runtime_error where it cannot be written.
void write_closed_loops(const std::vector<ClosedLoopRow>& rows, const std::filesystem::path& folder);
// How many are accepted and bad, by decoder and coverage; the scenes of those that are.
void print_closed_loops(const std::vector<ClosedLoopRow>& rows, std::ostream& out);

}  // namespace afferent
