// Random cases over many orders of magnitude.
#pragma once

#include <cmath>
#include <random>

namespace afferent {

// Fifty digits take their time, and far more of it without optimisation.
#if defined(__OPTIMIZE__)
inline constexpr int cases = 300;
#else
inline constexpr int cases = 30;
#endif

inline double log_uniform(std::mt19937_64& random, double low, double high) {
    return low * std::pow(high / low, std::uniform_real_distribution<>()(random));
}

}  // namespace afferent
