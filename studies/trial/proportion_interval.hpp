// 95 % intervals of proportions that were counted: of one, and of the difference and the ratio of two that
// were counted in the same presentations.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

namespace afferent {

struct Bounds {
    double low;
    double high;
    bool holds(double value) const noexcept { return low <= value && value <= high; }
};

// How many standard deviations of a normal distribution hold 95 % of it.
inline constexpr double normal_95 = 1.959963984540054;

// What was counted: so many hits among so many.
struct Proportion {
    std::uint64_t hits = 0;
    std::uint64_t of = 0;

    // NaN where nothing was counted.
    double value() const noexcept { return static_cast<double>(hits) / static_cast<double>(of); }
};

// Wilson (J. Am. Stat. Assoc. 1927): the proportions p from which the counted one, q, is no further off than
// z standard deviations of a count under p,
//
//     |q - p| <= z sqrt(p (1 - p) / n)
//
// Holds the true proportion in 95 % of the cases near 0 and 1 as well, where the normal interval fails.
// [0, 1] where nothing was counted.
inline Bounds interval_95(const Proportion& counted) noexcept {
    if (counted.of == 0) return {0, 1};
    const double n = static_cast<double>(counted.of);
    const double q = counted.value();
    const double z2 = normal_95 * normal_95;
    const double centre = (q + z2 / (2 * n)) / (1 + z2 / n);
    const double half = normal_95 / (1 + z2 / n) * std::sqrt(q * (1 - q) / n + z2 / (4 * n * n));
    // Rounding must not take 0 and 1 out of the intervals that end there.
    return {counted.hits == 0 ? 0 : std::max(0.0, centre - half),
            counted.hits == counted.of ? 1 : std::min(1.0, centre + half)};
}

// The same presentations under two conditions.
struct PairedCount {
    std::uint64_t both = 0;
    std::uint64_t only_first = 0;
    std::uint64_t only_second = 0;
    std::uint64_t neither = 0;

    void add(bool first, bool second) noexcept {
        ++(first ? (second ? both : only_first) : (second ? only_second : neither));
    }
    std::uint64_t of() const noexcept { return both + only_first + only_second + neither; }
    Proportion first() const noexcept { return {both + only_first, of()}; }
    Proportion second() const noexcept { return {both + only_second, of()}; }
};

struct Estimated {
    double value;
    Bounds interval;
};

// The second proportion less the first. Presentations that came out alike under both tell nothing of it: its
// variance is (b + c - (b - c)^2 / n) / n^2, with b and c those that came out otherwise. None without a
// presentation.
inline std::optional<Estimated> difference(const PairedCount& counted) noexcept {
    if (counted.of() == 0) return std::nullopt;
    const double n = static_cast<double>(counted.of());
    const double b = static_cast<double>(counted.only_second);
    const double c = static_cast<double>(counted.only_first);
    const double half = normal_95 * std::sqrt(std::max(0.0, b + c - (b - c) * (b - c) / n)) / n;
    const double value = (b - c) / n;
    return Estimated{value, {value - half, value + half}};
}

// The second proportion less the first, of presentations that have nothing in common: Newcombe (Stat. Med.
// 1998), method 10, from the Wilson intervals of the two. None where one of them was not counted.
inline std::optional<Estimated> difference(const Proportion& first, const Proportion& second) noexcept {
    if (first.of == 0 || second.of == 0) return std::nullopt;
    const Bounds one = interval_95(first), other = interval_95(second);
    const double value = second.value() - first.value();
    return Estimated{value,
                     {value - std::hypot(second.value() - other.low, one.high - first.value()),
                      value + std::hypot(other.high - second.value(), first.value() - one.low)}};
}

// The second proportion over the first. Its logarithm has the variance (b + c) / (n1 n2), with n1 and n2 the
// hits of the two (Desu and Raghavarao, Nonparametric Statistical Methods for Complete and Censored Data,
// 2004). None where one of them has no hits.
inline std::optional<Estimated> ratio(const PairedCount& counted) noexcept {
    const double n1 = static_cast<double>(counted.first().hits);
    const double n2 = static_cast<double>(counted.second().hits);
    if (n1 == 0 || n2 == 0) return std::nullopt;
    const double apart = static_cast<double>(counted.only_first + counted.only_second);
    const double factor = std::exp(normal_95 * std::sqrt(apart / (n1 * n2)));
    const double value = n2 / n1;
    return Estimated{value, {value / factor, value * factor}};
}

}  // namespace afferent
