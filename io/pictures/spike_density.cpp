#include "afferent/io/pictures/spike_density.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "afferent/io/pictures/gnuplot_script.hpp"

namespace afferent {
namespace {

// A cell is two pixels of the SVG or more, each way.
constexpr std::size_t cells_across = 350;
constexpr std::size_t most_lines = 90;

std::array<double, 3> parts_of(std::string_view colour) {
    std::array<double, 3> parts{};
    for (std::size_t i = 0; i < 3; ++i) {
        int value = 0;
        std::from_chars(colour.data() + 1 + 2 * i, colour.data() + 3 + 2 * i, value, 16);
        parts[i] = value;
    }
    return parts;
}

}  // namespace

SpikeDensity::SpikeDensity(double begin_s, double end_s, std::uint32_t rows)
    : SpikeDensity(begin_s, end_s, std::vector<std::uint32_t>(rows, 1)) {}

SpikeDensity::SpikeDensity(double begin_s, double end_s, std::span<const std::uint32_t> neurons_of_row)
    : begin_s_(begin_s),
      end_s_(end_s),
      rows_(static_cast<std::uint32_t>(neurons_of_row.size())),
      lines_(std::clamp<std::size_t>(rows_, 1, most_lines)),
      neurons_(lines_),
      counts_(cells_across * lines_) {
    for (std::uint32_t row = 0; row < rows_; ++row) neurons_[line_of(row)] += neurons_of_row[row];
}

void SpikeDensity::add(std::span<const Event> events) {
    const double cells_per_s = static_cast<double>(cells_across) / (end_s_ - begin_s_);
    for (const Event& event : events) {
        const double cell = std::floor((seconds(event.time) - begin_s_) * cells_per_s);
        if (event.address >= rows_ || !(cell >= 0 && cell < static_cast<double>(cells_across))) continue;
        ++counts_[line_of(event.address) * cells_across + static_cast<std::size_t>(cell)];
    }
}

std::vector<double> SpikeDensity::spikes_of_a_neuron() const {
    std::vector<double> spikes(counts_.begin(), counts_.end());
    for (std::size_t line = 0; line < lines_; ++line)
        for (std::size_t cell = 0; cell < cells_across; ++cell)
            spikes[line * cells_across + cell] /= std::max(1U, neurons_[line]);
    return spikes;
}

double SpikeDensity::peak_hz() const {
    const double cell_s = (end_s_ - begin_s_) / static_cast<double>(cells_across);
    return std::ranges::max(spikes_of_a_neuron()) / cell_s;
}

std::string SpikeDensity::data(std::string_view name, std::span<const Hue> hues) const {
    std::string block = std::string(name) + " << EOD\n";
    const std::vector<double> spikes = spikes_of_a_neuron();
    const double peak = std::ranges::max(spikes);
    const double most = peak > 0 ? peak : 1;
    for (std::size_t line = 0; line < lines_; ++line) {
        const double row = (static_cast<double>(line) + 0.5) * rows_ / static_cast<double>(lines_) - 0.5;
        std::array<double, 3> full{64, 64, 64};
        for (const Hue& hue : hues)
            if (row >= hue.first - 0.5 && row < hue.first - 0.5 + hue.rows) full = parts_of(hue.colour);
        for (std::size_t cell = 0; cell < cells_across; ++cell) {
            // The square root makes a lone spike among many visible.
            const double share = std::sqrt(spikes[line * cells_across + cell] / most);
            const double time_s =
                begin_s_ + (static_cast<double>(cell) + 0.5) * (end_s_ - begin_s_) / cells_across;
            for (const double value : {time_s, row}) block += gnuplot_number(value) + ' ';
            for (const double part : full)
                block += gnuplot_number(std::round(255 - share * (255 - part))) + ' ';
            block += '\n';
        }
    }
    return block + "EOD\n";
}

}  // namespace afferent
