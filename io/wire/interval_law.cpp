#include "afferent/io/wire/interval_law.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace afferent {
namespace {

__extension__ using Wide = __int128;

constexpr std::uint32_t most = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint64_t one = std::uint64_t{1} << 32;

// Columns: t from one tick, eight to an octave.
constexpr std::uint32_t shortest_t = 16;
constexpr std::uint32_t longest_t = shortest_t * IntervalLaw::longest;
constexpr std::uint32_t column_of(std::uint32_t t) noexcept {
    const auto octave = static_cast<std::uint32_t>(std::bit_width(t)) - 1;
    return (octave - 4) * 8 + (t >> (octave - 3) & 7);
}
constexpr std::uint32_t time_of(std::uint32_t column) noexcept {
    return (8 + column % 8) << (column / 8 + 1);
}
// The steps are powers of two.
constexpr std::uint32_t width_bits_of(std::uint32_t column) noexcept { return column / 8 + 1; }
constexpr std::uint32_t columns = column_of(longest_t) + 1;

// Rows: g, four to an octave.
constexpr std::uint32_t smallest_g = 4;
constexpr std::uint32_t row_of(std::uint32_t g) noexcept {
    const auto octave = static_cast<std::uint32_t>(std::bit_width(g)) - 1;
    return (octave - 2) * 4 + (g >> (octave - 2) & 3);
}
constexpr std::uint32_t adaptation_of(std::uint32_t row) noexcept { return (4 + row % 4) << (row / 4); }

std::uint64_t product(std::uint64_t a, std::uint64_t b) noexcept {
    return static_cast<std::uint64_t>(Wide{a} * b >> 32);
}

// e^(−x); both in 2^-32.
std::uint64_t exponential(std::uint64_t x) noexcept {
    if (x >= 23 * one) return 0;
    // The series up to 1/8; then squared as often as x was halved.
    const int halvings = std::max(0, static_cast<int>(std::bit_width(x)) - 29);
    const std::uint64_t y = x >> halvings;
    std::uint64_t sum = one;
    for (std::uint64_t term = 8; term > 0; --term) sum = one - product(y, sum) / term;
    for (int halving = 0; halving < halvings; ++halving) sum = product(sum, sum);
    return sum;
}

// Each of these is one correctly rounded operation of IEEE 754 and one conversion: the same everywhere.
std::int64_t scaled(double value, int bits, double lowest, double highest) noexcept {
    return std::llround(std::ldexp(std::clamp(value, lowest, highest), bits));
}

}  // namespace

IntervalLaw::IntervalLaw(const NeuronLaw& law, Duration tick)
    : jump_(static_cast<std::uint32_t>(scaled(law.delta_g, 16, 0, 16'383))) {
    if (jump_ < smallest_g) jump_ = 0;
    const double tick_ms = static_cast<double>(tick.count()) / 1e6;
    refractory_ = static_cast<std::uint32_t>(scaled(law.refractory_ms / tick_ms, 4, 0, longest));
    const auto rate = static_cast<std::uint64_t>(scaled(tick_ms / law.tau_g_ms, 32, 0, 64));
    for (std::uint32_t place = 0; place < 3; ++place)
        for (std::uint32_t digit = 0; digit < 64; ++digit)
            decay_[place][digit] = static_cast<std::uint32_t>(
                std::min<std::uint64_t>(most, exponential((std::uint64_t{digit} << (6 * place)) * rate)));
    // The adaptation of a neuron that fires at every tick.
    most_g_ = jump_;
    if (jump_ > 0)
        most_g_ = static_cast<std::uint32_t>(
            std::min<std::uint64_t>(one * jump_ / (one - decay_[0][1]), std::uint64_t{1} << 30));

    if (jump_ == 0) {
        drives_.resize(columns);
        fill_row(0, tick_ms, law, drives_.data());
        return;
    }
    first_row_ = row_of(jump_);
    const std::uint32_t rows = row_of(most_g_) + 2 - first_row_;
    drives_.resize(std::size_t{rows} * columns);
    for (std::uint32_t row = 0; row < rows; ++row)
        fill_row(adaptation_of(first_row_ + row), tick_ms, law, &drives_[std::size_t{row} * columns]);
}

// From column to column as if g stood at its value in the middle: Φ and Ψ are exact for that.
void IntervalLaw::fill_row(std::uint32_t g, double tick_ms, const NeuronLaw& law, std::uint32_t* row) const {
    const double threshold_mv = law.v_th_mv - law.e_k_mv;
    const std::int64_t reset = scaled((law.v_r_mv - law.e_k_mv) / threshold_mv, 32, -256, 1);
    // In 2^-48, of a sixteenth of a tick.
    const std::int64_t membrane = scaled(tick_ms / law.tau_m_ms, 44, 0, 65'536);
    const std::int64_t adaptation = scaled(tick_ms / law.tau_g_ms, 44, 0, 65'536);
    const auto decay = [](Wide exponent) {  // in 2^-48
        return exponential(static_cast<std::uint64_t>(std::min(exponent >> 16, Wide{24} << 32)));
    };
    std::uint64_t g_now = g * one >> 16;  // in 2^-32
    g_now = product(g_now, decay(Wide{adaptation} * refractory_));
    std::uint64_t phi = one;
    std::uint64_t psi = 0;
    std::uint32_t t = 0;
    std::uint32_t before = most;
    for (std::uint32_t column = 0; column < columns; ++column) {
        const std::uint32_t step = time_of(column) - t;
        t = time_of(column);
        const std::uint64_t conductance = one + product(g_now, decay(Wide{adaptation} * step / 2));
        const std::uint64_t kept = decay(Wide{membrane} * step * conductance >> 32);
        phi = product(phi, kept);
        psi = product(psi, kept) + static_cast<std::uint64_t>((Wide{one - kept} << 32) / conductance);
        g_now = product(g_now, decay(Wide{adaptation} * step));
        const Wide left = Wide{one} - (Wide{reset} * phi >> 32);
        const Wide drive = psi == 0 ? Wide{most} : (left << 24) / psi;
        before = static_cast<std::uint32_t>(std::clamp(drive, Wide{0}, Wide{before}));
        row[column] = before;
    }
}

std::uint32_t IntervalLaw::Row::drive(std::uint32_t column) const noexcept {
    const auto low = static_cast<std::int64_t>(below[column]);
    const auto high = static_cast<std::int64_t>(above[column]);
    return static_cast<std::uint32_t>(low + (((high - low) * part) >> 16));
}

IntervalLaw::Row IntervalLaw::row(std::uint32_t g) const noexcept {
    if (jump_ == 0) return {drives_.data(), drives_.data(), 0};
    const std::uint32_t within = std::clamp(g, jump_, most_g_);
    const std::uint32_t found = row_of(within);
    const std::uint32_t begin = adaptation_of(found);
    const std::uint32_t* below = &drives_[std::size_t{found - first_row_} * columns];
    return {below, below + columns,
            static_cast<std::uint32_t>((std::uint64_t{within - begin} << 16) >> (found / 4))};
}

std::uint32_t IntervalLaw::drive(std::uint32_t interval, std::uint32_t g) const noexcept {
    const std::uint32_t t = std::clamp(interval - std::min(interval, refractory_), shortest_t, longest_t - 1);
    const Row values = row(g);
    const std::uint32_t column = column_of(t);
    const std::uint32_t begin = time_of(column);
    const std::int64_t high = values.drive(column);
    const std::int64_t low = values.drive(column + 1);
    return static_cast<std::uint32_t>(high - ((high - low) * (t - begin) >> width_bits_of(column)));
}

std::uint32_t IntervalLaw::interval(std::uint32_t drive, std::uint32_t g, std::uint32_t near) const noexcept {
    const Row values = row(g);
    if (drive >= values.drive(0)) return refractory_ + shortest_t;
    // Drives fall from column to column: the last that is above this one, from where it is likely to be.
    std::uint32_t above =
        column_of(std::clamp(near - std::min(near, refractory_), shortest_t, longest_t - 1));
    while (values.drive(above) <= drive) --above;
    while (above + 1 < columns && values.drive(above + 1) > drive) ++above;
    if (above + 1 == columns) return 0;
    const std::int64_t high = values.drive(above);
    const std::int64_t low = values.drive(above + 1);
    const std::int64_t width = std::int64_t{1} << width_bits_of(above);
    return static_cast<std::uint32_t>(refractory_ + time_of(above) + width * (high - drive) / (high - low));
}

std::uint32_t IntervalLaw::next_adaptation(std::uint32_t g, std::uint32_t ticks) const noexcept {
    if (ticks >> 18 != 0) return jump_;
    std::uint64_t kept = g;
    for (std::uint32_t place = 0; place < 3; ++place)
        kept = kept * decay_[place][ticks >> (6 * place) & 63] >> 32;
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(kept + jump_, most_g_));
}

}  // namespace afferent
