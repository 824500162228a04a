// Question: does the gain keep a grip force at its limit? Random closed loops of a simulated hand, in which
// what the decoder is told of its sensors and what they are is drawn apart.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "afferent/scene/gain_reach.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// A hand that is not quite what its scene says.
struct ClosedLoop {
    Scene told;  // it accepts an unreachable limit, so that it can be planned
    // What keeps a scene like it from being planned that does not accept that; empty: nothing.
    std::string refusal;
    // What differs: "nothing", "gains", "shares", "tau_g", "dead" or "hysteresis".
    std::string wrong;
    std::vector<double> gains;  // of the elements, as factors of what they are told to be
    std::vector<std::uint32_t> dead;
    double tau_g = 1;       // a factor
    double hysteresis = 0;  // of the sensors
};

// The index-th of the loops that a seed gives; each is drawn by itself.
ClosedLoop draw_closed_loop(std::uint64_t seed, std::uint64_t index);

struct ClosedLoopResult {
    std::string decoder;
    std::uint32_t elements;
    double limit_n;
    // The grip force at which the last element is at its full scale.
    double full_scale_n;
    // What the scene's check goes by.
    GainReach reach;
    // The grip force that the sensors tell as the limit, by what is wrong with them: none they tell is beyond
    // half again of it.
    double told_limit_n;
    double peak_n;
    // How far the hand would have gone, had its command ended when the force had passed that limit and the
    // link, the sensors and the envelope had told it.
    double momentum_n;
    // How long the force was more than 1 N above both with the gain open.
    double above_s;

    // Whether the force was beyond what momentum explains for longer than a tenth of a second.
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
