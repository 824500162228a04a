// The vectorised inner loops of DensePopulation, compiled once for every instruction set.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "afferent/neurons/interval_polynomials.hpp"

namespace afferent::dense {

// Neurons that are swept, and whose crossings are solved, while they are in the cache.
inline constexpr std::size_t tile = 1024;
inline constexpr std::size_t max_lanes = 8;
inline constexpr std::size_t max_terms = 40;

// Constants of a population. Time is in units of tau_m; the names are those of Membrane and ShortInterval.
struct Model {
    bool adapts;
    bool individual;  // threshold and Δg differ between neurons
    double tau_ns;
    double a;
    double step;     // a scan interval, or an equal part of one
    double decay;    // e^(−step)
    double fall;     // expm1(−step/a)
    double g_limit;  // largest g for which the series of a crossing holds
    double graze;    // a crossing with a smaller slope, relative to z's terms, is left to the scalar solver
    std::size_t terms;  // of that series; a multiple of four
    IntervalPolynomials polynomials;
    double v_r_mv;
    double e_k_mv;
    double v_th_mv;
    double delta_g;
};

// One entry for each neuron, padded to whole vectors with neurons that never fire.
struct Neurons {
    double* gap_mv;
    double* g;              // null unless the model adapts
    const double* v_th_mv;  // null unless individual
    const double* delta_g;  // null unless individual and the model adapts
};

// Neurons that are each at their own time within the step, with the time left in it.
struct Batch {
    static constexpr std::size_t capacity = tile + max_lanes;
    alignas(64) std::array<double, capacity> gap_mv;
    alignas(64) std::array<double, capacity> g;
    alignas(64) std::array<double, capacity> excess_mv;
    alignas(64) std::array<double, capacity> left;  // adapting: expm1(−time left/a); else e^(−time left)
    alignas(64) std::array<double, capacity> elapsed;  // since the step began
    alignas(64) std::array<std::int64_t, capacity> index;
    std::size_t size = 0;
};

struct Kernel {
    // Advances neurons [begin, begin + count) over a step. Those that reach threshold, or whose g is beyond
    // the polynomials, are not changed but appended to `crossing`. count is a multiple of the lanes and at
    // most a tile; drives_mv[0] is that of neuron `begin`.
    void (*sweep)(const Model&, const Neurons&, const double* drives_mv, std::size_t begin, std::size_t count,
                  Batch& crossing);
    // Solves the crossings and leaves the neurons in their state after the spike. Writes a key for each to
    // `keys` (nanoseconds since the scan interval began << 32 | index) and, unless it is null, the time
    // before rounding to `times_ns`; both have room for one entry per crossing and max_lanes more. Crossings
    // that the series cannot solve are moved to `hard`. Returns the number of keys.
    std::size_t (*fire)(const Model&, const Neurons&, double start_ns, double end_ns, Batch& crossing,
                        Batch& hard, std::uint64_t* keys, double* times_ns);
    // Advances neurons to the end of the step. Those that reach threshold again remain in the batch.
    void (*finish)(const Model&, const Neurons&, Batch& batch);
    std::size_t lanes;
    const char* name;
};

// For the best instruction set that the processor has and that Highway has not been told to leave out.
Kernel kernel();

}  // namespace afferent::dense
