// Reduces long curves and many spikes to the few points that look the same in a picture.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "afferent/runtime/event.hpp"

namespace afferent {

// Each returns a named block of data for gnuplot, with the columns
//   x, y         of a curve: the lowest and the highest of each stretch, so that no peak is lost
std::string curve_data(std::string_view name, std::span<const double> x, std::span<const double> y);
//   x, low, high of the band centre ± half_width, not below 0, around all of the envelope where there is one
std::string band_data(std::string_view name, std::span<const double> x, std::span<const double> centre,
                      std::span<const double> half_width);
//   x, low, high, mean of a curve that moves faster than a picture can show: of every few pixels
std::string envelope_data(std::string_view name, std::span<const double> x, std::span<const double> y);
// Whether a curve has so many points that its envelope shows more than the curve.
bool wants_envelope(std::size_t points);
//   x, address   of the spikes that lie at least a pixel apart; `rows` is the number of addresses
std::string spike_data(std::string_view name, std::span<const Event> events, double begin_s, double end_s,
                       Address rows);

}  // namespace afferent
