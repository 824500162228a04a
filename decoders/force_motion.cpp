#include "afferent/decoders/force_motion.hpp"

#include <algorithm>
#include <cmath>

namespace afferent {
namespace {

// Steps are short against the time constants, and there the series are faster than the functions.
constexpr double short_step = 0.2;

// 2r − 3 + 4e^(−r) − e^(−2r), whose terms cancel where r is small.
double spread(double r, double lost) {
    if (r > short_step) return 2 * r - 4 * lost + lost * (2 - lost);
    return r * r * r *
           (2.0 / 3 - r * (1.0 / 2 - r * (7.0 / 30 - r * (1.0 / 12 - r * (31.0 / 1260 - r / 160)))));
}

}  // namespace

double lost_fraction(double r) noexcept {
    if (r > short_step) return -std::expm1(-r);
    return r * (1 - r / 2 * (1 - r / 3 * (1 - r / 4 * (1 - r / 5 * (1 - r / 6 * (1 - r / 7))))));
}

ForceFlow wandering(const ForceMotion& motion, double dt_s) noexcept {
    const double r = dt_s / motion.time_s;
    const double lost = lost_fraction(r);
    const double kept = 1 - lost;
    const double vv = motion.speed_n_per_s * motion.speed_n_per_s;
    return {.a = 1,
            .b = motion.time_s * lost,
            .c = 0,
            .d = kept,
            .ff = vv * motion.time_s * motion.time_s * spread(r, lost) + motion.drift_n2_per_s * dt_s,
            .fv = vv * motion.time_s * lost * lost,
            .vv = vv * lost * (1 + kept)};
}

ForceFlow returning(const ForceMotion& motion, double dt_s) noexcept {
    const double r = dt_s / motion.time_s;
    const double kept = 1 - lost_fraction(r);
    const double noisy_s = std::min(dt_s, motion.time_s / 2);
    const double noise = 2 * motion.speed_n_per_s * motion.speed_n_per_s * noisy_s / motion.time_s;
    return {.a = kept * (1 + r),
            .b = kept * dt_s,
            .c = -kept * r / motion.time_s,
            .d = kept * (1 - r),
            .ff = noise * noisy_s * noisy_s / 3 + motion.drift_n2_per_s * dt_s,
            .fv = noise * noisy_s / 2,
            .vv = noise};
}

ForceFlow flow(const ForceBeliefParameters& parameters, std::size_t motion, double dt_s) noexcept {
    const ForceMotion& of = parameters.motion[motion];
    return motion == ForceBeliefParameters::release ? returning(of, dt_s) : wandering(of, dt_s);
}

}  // namespace afferent
