// One population for other simulators: its parameters, its drives, and the spikes that it has.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>

#include "afferent/runtime/time.hpp"

namespace afferent::bench {

struct ScaleExport {
    std::size_t events;
    // What a run takes on one thread, by its own time, from samples to sorted events: the median of five.
    double dense_s;
    double sparse_s;
};

// Writes into the folder, of a population that is touched all over and begins at rest in its phases:
//   parameters.csv    a row: elements, frames, frame_ms, tau_m_ms, tau_g_ms, v_r_mv, e_k_mv, delta_g, events,
//                     dense_s, sparse_s
//   v_th_mv.npy, v_mv.npy              of each element: threshold, and where it begins
//   drives_mv.npy                      frame by frame, of each element, held until the next frame
//   spike_time_ns.npy, spike_address.npy
// Both forms have the same events within 1 ns; written are those of the sweep, sorted by address. Throws
// std::runtime_error where they have not, or where a file cannot be written.
ScaleExport export_population(std::uint32_t elements, Duration duration, const std::filesystem::path& folder);

}  // namespace afferent::bench
