// How densely very many spikes lie over time and address, in place of the spikes themselves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "afferent/runtime/event.hpp"

namespace afferent {

class SpikeDensity {
  public:
    // With a neuron in each row, or so many.
    SpikeDensity(double begin_s, double end_s, std::uint32_t rows);
    SpikeDensity(double begin_s, double end_s, std::span<const std::uint32_t> neurons_of_row);

    // Events outside of the time and the rows are passed over.
    void add(std::span<const Event> events);

    // The highest rate of a neuron in a cell, in Hz: what is drawn in full colour.
    double peak_hz() const;

    struct Hue {
        Address first;
        std::uint32_t rows;
        std::string_view colour;  // "#RRGGBB"
    };
    // A named block of data for gnuplot's rgbimage: x, y, red, green, blue, from white to the hue of the row.
    std::string data(std::string_view name, std::span<const Hue> hues) const;

  private:
    std::size_t line_of(std::uint32_t row) const { return std::uint64_t{row} * lines_ / rows_; }
    // For each cell, line by line: the mean number of spikes of one of its neurons.
    std::vector<double> spikes_of_a_neuron() const;

    double begin_s_;
    double end_s_;
    std::uint32_t rows_;
    std::size_t lines_;
    std::vector<std::uint32_t> neurons_;  // of each line
    std::vector<std::uint32_t> counts_;   // line by line
};

}  // namespace afferent
