// The vectorised inner loops of DensePopulation, compiled once for every instruction set.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "afferent/neurons/frame_polynomials.hpp"

namespace afferent::dense {

// A tile is swept, and its crossings solved, while it is in the cache.
inline constexpr std::size_t tile = 1024;
inline constexpr std::size_t max_lanes = 8;
inline constexpr std::size_t max_terms = 40;

// What holds for a whole population. Time is in units of tau_m; the names are those of Membrane and
// ShortInterval.
struct Model {
    bool adapts;
    bool individual;  // threshold and Δg differ between neurons
    double tau_ns;
    double a;
    double step;        // a frame, or an equal part of one
    double decay;       // e^(−step)
    double fall;        // expm1(−step/a)
    double g_limit;     // the series of a crossing holds up to here
    double graze;       // a crossing this flat, beside what z is made of, is left to the scalar solver
    std::size_t terms;  // of that series; a multiple of four
    FramePolynomials polynomials;
    double v_r_mv;
    double e_k_mv;
    double v_th_mv;
    double delta_g;
};

// One entry for each neuron; padded to whole vectors with neurons that never fire.
struct Neurons {
    double* gap_mv;
    double* g;              // null unless the model adapts
    const double* v_th_mv;  // null unless individual
    const double* delta_g;  // null unless individual and the model adapts
};

// Neurons at a time of their own within the step, with what is left of it.
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
    // Carries neurons [begin, begin + count) over a step. Those that reach threshold, or are beyond the
    // polynomials, are left as they are and put into `crossing`. count is a multiple of the lanes, at most a
    // tile; the drives are its own.
    void (*sweep)(const Model&, const Neurons&, const double* drives_mv, std::size_t begin, std::size_t count,
                  Batch& crossing);
    // Solves the crossings: appends a key (time in ns from the frame's beginning << 32 | index) for each to
    // `keys`, with room for one each and max_lanes more, and unless it is null their unrounded times to
    // `times_ns`, and leaves the neurons as they are after their
    // spike. Those that the series does not serve go to `hard`.
    std::size_t (*fire)(const Model&, const Neurons&, double start_ns, double end_ns, Batch& crossing,
                        Batch& hard, std::uint64_t* keys, double* times_ns);
    // Carries neurons to the end of the step. Those that reach threshold again remain in the batch.
    void (*finish)(const Model&, const Neurons&, Batch& batch);
    std::size_t lanes;
    const char* name;
};

// For the best instruction set that the processor has and Highway has not been told to leave out.
Kernel kernel();

}  // namespace afferent::dense
