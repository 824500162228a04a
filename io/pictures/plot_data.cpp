#include "afferent/io/pictures/plot_data.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "afferent/io/pictures/gnuplot_script.hpp"

namespace afferent {
namespace {

// Twice the pixels of the PNG, across and down a panel: nothing finer can be seen.
constexpr std::size_t stretches = 1500;
// A stretch of an envelope is two pixels of the SVG long. Each point stands for twice that, so that stretches
// do not beat with the steps of a rate.
constexpr std::size_t envelope_stretches = 350;
constexpr std::size_t columns = 3000;
constexpr std::size_t lines = 1000;

std::string begin_block(std::string_view name) { return std::string(name) + " << EOD\n"; }

void add_point(std::string& block, std::initializer_list<double> values) {
    for (const double value : values) block += gnuplot_number(value) + ' ';
    block += '\n';
}

// Calls draw(first, last) for each stretch of samples without a gap in it, and gap() for each gap.
template <class Draw, class Gap>
void for_each_stretch(std::span<const double> y, std::size_t most, Draw draw, Gap gap) {
    const std::size_t longest = std::max<std::size_t>(1, y.size() / most);
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

// Lengthens the stretch at each end by half its length, but not across a gap.
std::pair<std::size_t, std::size_t> widened(std::span<const double> y, std::size_t first, std::size_t last) {
    for (std::size_t more = (last - first + 1) / 2; more > 0; --more) {
        if (first > 0 && std::isfinite(y[first - 1])) --first;
        if (last + 1 < y.size() && std::isfinite(y[last + 1])) ++last;
    }
    return {first, last};
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
    for_each_stretch(y, stretches, draw, [&] { block += '\n'; });
    return block + "EOD\n";
}

std::string band_data(std::string_view name, std::span<const double> x, std::span<const double> centre,
                      std::span<const double> half_width) {
    assert(x.size() == centre.size() && x.size() == half_width.size());
    std::string block = begin_block(name);
    const bool wide = wants_envelope(centre.size());
    const auto draw = [&](std::size_t first, std::size_t last) {
        const double time = std::midpoint(x[first], x[last]);
        double low = centre[first];
        double high = centre[first];
        if (wide) std::tie(first, last) = widened(centre, first, last);
        for (std::size_t i = first; i <= last; ++i) {
            if (!std::isfinite(half_width[i])) continue;
            low = std::min(low, centre[i] - half_width[i]);
            high = std::max(high, centre[i] + half_width[i]);
        }
        add_point(block, {time, std::max(low, 0.0), std::max(high, 0.0)});
    };
    for_each_stretch(centre, wide ? envelope_stretches : stretches, draw, [&] { block += '\n'; });
    return block + "EOD\n";
}

bool wants_envelope(std::size_t points) { return points > 4 * envelope_stretches; }

std::string envelope_data(std::string_view name, std::span<const double> x, std::span<const double> y) {
    assert(x.size() == y.size());
    std::string block = begin_block(name);
    const auto draw = [&](std::size_t first, std::size_t last) {
        const double time = std::midpoint(x[first], x[last]);
        std::tie(first, last) = widened(y, first, last);
        const auto part = y.subspan(first, last - first + 1);
        const auto [low, high] = std::ranges::minmax_element(part);
        const double mean = std::accumulate(part.begin(), part.end(), 0.0) / static_cast<double>(part.size());
        add_point(block, {time, *low, *high, mean});
    };
    for_each_stretch(y, envelope_stretches, draw, [&] { block += '\n'; });
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
