// The vectorised inner loops of DensePopulation, compiled once for every instruction set.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "afferent/neurons/interval_polynomials.hpp"

namespace afferent::dense {

// Neurons that are swept, and whose crossings are solved, while they are in the cache.
inline constexpr std::size_t tile = 512;
inline constexpr std::size_t max_lanes = 8;
inline constexpr std::size_t max_terms = 40;
// The numbers of coefficients for which there is a sweep without a loop over them.
inline constexpr std::array near_counts{8, 12, 16};

// Constants of a population. Time is in units of tau_m; the names are those of Membrane and ShortInterval.
struct Model {
    bool adapts;
    double tau_ns;
    double a;
    double step;     // a scan interval, or an equal part of one
    double decay;    // e^(−step)
    double fall;     // expm1(−step/a)
    double g_limit;  // largest g for which the series of a crossing holds
    double graze;    // a crossing with a smaller slope, relative to z's terms, is left to the scalar solver
    // How many terms of that series a neuron needs whose g and time let z grow by e^growth at most.
    struct Level {
        double growth;
        std::size_t terms;
    };
    std::array<Level, 5> levels;
    std::array<double, 10> log_terms;  // of s/y in y², where s = −a log1p(ε) and y = ε/(2 + ε)
    std::size_t log_count;
    // Over a step, for every g that the sweep takes, and with near_counts coefficients for the g of usual
    // rates.
    IntervalPolynomials far;
    IntervalPolynomials near;
    double v_r_mv;
    double e_k_mv;
};

// One entry for each neuron, padded to whole vectors with neurons that never fire. All conductances decay by
// the same factor, so that it is stored once: g is scaled_g · scale when the step begins, and · end_scale
// when it ends.
struct Neurons {
    double* gap_mv;
    double* scaled_g;       // null unless the model adapts
    const double* v_th_mv;  // null unless each has its own
    const double* delta_g;  // null unless each has its own
    double common_v_th_mv;
    double common_delta_g;
    bool rest;  // after a spike, for a refractory period
    double scale;
    double end_scale;
};

// Neurons that are each at their own time within the step, with the time left in it. There is room for a
// tile's and for those that wait from the tiles before it.
struct Batch {
    static constexpr std::size_t capacity = 2 * tile;
    alignas(64) std::array<double, capacity> gap_mv;
    alignas(64) std::array<double, capacity> g;
    alignas(64) std::array<double, capacity> excess_mv;
    alignas(64) std::array<double, capacity> end_mv;  // the gap at the end of the step, if nothing happened
    alignas(64) std::array<double, capacity> left;  // adapting: expm1(−time left/a); else e^(−time left)
    alignas(64) std::array<double, capacity> elapsed;  // since the step began
    alignas(64) std::array<std::int64_t, capacity> index;
    std::size_t size = 0;
};

struct Kernel {
    // Advances neurons [begin, begin + count) over a step. Those that reach threshold are not changed but
    // appended to `crossing`, those whose g is beyond the polynomials to `hard`. count is a multiple of the
    // lanes and at most a tile; drives_mv[0] is that of neuron `begin`.
    void (*sweep)(const Model&, const Neurons&, const double* drives_mv, std::size_t begin, std::size_t count,
                  Batch& crossing, Batch& hard);
    // Solves the crossings and writes a key for each to `keys` (nanoseconds since the scan interval began <<
    // 32 | index) and, unless it is null, the time before rounding to `times_ns`; both have room for one
    // entry per crossing and max_lanes more. Where neurons do not rest, they are advanced to the end of the
    // step, and those that reach threshold again are appended to `after`; where they rest, all of them are
    // appended to `after`, in their state after the spike. Crossings that the series cannot solve are
    // appended to `hard`. Returns the number of keys.
    std::size_t (*fire)(const Model&, const Neurons&, double start_ns, double end_ns, const Batch& crossing,
                        Batch& after, Batch& hard, std::uint64_t* keys, double* times_ns);
    // Advances neurons to the end of the step. Those that reach threshold are appended to `crossing`, those
    // whose g is beyond the series to `hard`.
    void (*finish)(const Model&, const Neurons&, const Batch& batch, Batch& crossing, Batch& hard);
    std::size_t lanes;
    std::size_t group;  // crossings that `fire` solves together
    const char* name;
};

// For the best instruction set that the processor has and that Highway has not been told to leave out.
Kernel kernel();

}  // namespace afferent::dense
