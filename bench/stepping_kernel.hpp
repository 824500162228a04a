// The inner loops of the solvers that step, for the best instruction set of the machine.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace afferent::bench::stepping {

// w = v − E_k, in mV, and g; times in units of tau_m. For each method what a step comes to under a held
// drive, where b = v_r + R·I − E_k and a = tau_g/tau_m:
//     dw/dt = b − (1 + g) w,   dg/dt = −g/a
enum class Method { euler, exponential_euler, rk4 };

constexpr std::size_t tile_size = 512;  // its state stays in the first-level cache

template <class Real>
struct Constants {
    Real step;
    Real inverse_a;
    Real reset;              // v_r − E_k
    Real decay, half_decay;  // of g in a step, and in half of one
    Real fall;               // 1 − step/a: of g in Euler's step
};

template <class Real>
using TileRow = std::array<Real, tile_size>;

// State before and after a step, which are exchanged by their pointers.
template <class Real>
struct Tile {
    alignas(64) std::array<TileRow<Real>, 2> w_rows{}, g_rows{};
    alignas(64) TileRow<Real> b{}, threshold{}, delta_g{};
    alignas(
        64) std::array<std::uint8_t, tile_size> crossed{};  // sets of lanes, a byte or more for each vector
    TileRow<Real>*w = &w_rows[0], *g = &g_rows[0], *next_w = &w_rows[1], *next_g = &g_rows[1];
};

// Neurons that have reached their threshold in what is left of a step. In: their state before it. Out: when
// they do; the state at the step's end, after a reset at the crossing; and whether they cross again.
template <class Real>
struct Crossings {
    std::size_t count = 0;
    alignas(64) std::array<std::uint32_t, tile_size> index{};
    alignas(64) TileRow<Real> w{}, g{}, b{}, threshold{}, delta_g{}, left{};
    alignas(64) TileRow<Real> span{}, end_w{}, end_g{};

    void move(std::size_t from, std::size_t to) {
        index[to] = index[from];
        for (TileRow<Real>* row : {&w, &g, &b, &threshold, &delta_g, &left, &end_w})
            (*row)[to] = (*row)[from];
    }
};

template <class Real>
struct Kernel {
    // The drives of a row.
    void (*set_drives)(const double* drives_mv, double offset_mv, std::size_t size, Tile<Real>& tile);
    // A step of the neurons below `size`, and those that cross in it.
    void (*step)(const Constants<Real>&, std::size_t size, Tile<Real>& tile, Crossings<Real>& crossings);
    // Finds `span`, `end_w` and `end_g` of all crossings.
    void (*resolve)(const Constants<Real>&, Crossings<Real>& crossings);
};

// For the instruction set that Highway chooses at the time of the call.
void choose(Method method, Kernel<float>& kernel);
void choose(Method method, Kernel<double>& kernel);

}  // namespace afferent::bench::stepping
