#include "afferent/io/pictures/plot_data.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "afferent/io/pictures/gnuplot_script.hpp"

namespace afferent {
namespace {

// Twice the pixels of the PNG, across and down a panel: finer than that nothing can be seen.
constexpr std::size_t stretches = 1500;
constexpr std::size_t columns = 3000;
constexpr std::size_t lines = 1000;

std::string begin_block(std::string_view name) { return std::string(name) + " << EOD\n"; }

void add_point(std::string& block, std::initializer_list<double> values) {
    for (const double value : values) block += gnuplot_number(value) + ' ';
    block += '\n';
}

// Calls draw(first, last) for each stretch of samples without a gap in it, and gap() for each gap.
template <class Draw, class Gap>
void for_each_stretch(std::span<const double> y, Draw draw, Gap gap) {
    const std::size_t longest = std::max<std::size_t>(1, y.size() / stretches);
    std::size_t i = 0;
    while (i < y.size()) {
        if (!std::isfinite(y[i])) {
            gap();
            ++i;
            continue;
        }
        std::size_t last = i;
        while (last + 1 < y.size() && last + 1 < i + longest && std::isfinite(y[last + 1])) ++last;
        draw(i, last);
        i = last + 1;
    }
}

}  // namespace

std::string curve_data(std::string_view name, std::span<const double> x, std::span<const double> y) {
    assert(x.size() == y.size());
    std::string block = begin_block(name);
    const auto draw = [&](std::size_t first, std::size_t last) {
        std::size_t low = first;
        std::size_t high = first;
        for (std::size_t i = first; i <= last; ++i) {
            if (y[i] < y[low]) low = i;
            if (y[i] > y[high]) high = i;
        }
        const std::size_t one = std::min(low, high);
        const std::size_t other = std::max(low, high);
        add_point(block, {x[one], y[one]});
        if (one != other) add_point(block, {x[other], y[other]});
    };
    for_each_stretch(y, draw, [&] { block += '\n'; });
    return block + "EOD\n";
}

std::string band_data(std::string_view name, std::span<const double> x, std::span<const double> centre,
                      std::span<const double> half_width) {
    assert(x.size() == centre.size() && x.size() == half_width.size());
    std::string block = begin_block(name);
    const auto draw = [&](std::size_t first, std::size_t last) {
        double low = centre[first];
        double high = centre[first];
        for (std::size_t i = first; i <= last; ++i) {
            if (!std::isfinite(half_width[i])) continue;
            low = std::min(low, centre[i] - half_width[i]);
            high = std::max(high, centre[i] + half_width[i]);
        }
        add_point(block, {std::midpoint(x[first], x[last]), std::max(low, 0.0), std::max(high, 0.0)});
    };
    for_each_stretch(centre, draw, [&] { block += '\n'; });
    return block + "EOD\n";
}

std::string spike_data(std::string_view name, std::span<const Event> events, double begin_s, double end_s,
                       Address rows) {
    const std::size_t lines_used = std::min<std::size_t>(rows, lines);
    std::vector<std::uint8_t> taken(columns * lines_used);
    std::string block = begin_block(name);
    for (const Event& event : events) {
        const double time_s = seconds(event.time);
        if (event.address >= rows || time_s < begin_s || time_s > end_s) continue;
        const auto column = static_cast<std::size_t>((time_s - begin_s) / (end_s - begin_s) * (columns - 1));
        const std::size_t line = event.address * lines_used / rows;
        if (std::exchange(taken[column * lines_used + line], std::uint8_t{1}) == 0)
            add_point(block, {time_s, static_cast<double>(event.address)});
    }
    return block + "EOD\n";
}

}  // namespace afferent
