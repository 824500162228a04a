// The values that a numeric field of a scene may have.
#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <string>

namespace afferent {

struct FieldRange {
    double lowest;
    double highest;
    bool lowest_allowed = true;
    bool highest_allowed = true;

    // False for NaN and infinity.
    bool holds(double value) const noexcept {
        return std::isfinite(value) && (lowest_allowed ? value >= lowest : value > lowest) &&
               (highest_allowed ? value <= highest : value < highest);
    }

    // "0.001 to 1000", "> 0 and at most 1e6", ">= 0 and < 1"
    std::string text() const {
        if (lowest_allowed && highest_allowed) return number(lowest) + " to " + number(highest);
        return (lowest_allowed ? ">= " : "> ") + number(lowest) +
               (highest_allowed ? " and at most " : " and < ") + number(highest);
    }

  private:
    // The shortest digits, without the sign and the zeros that to_chars gives an exponent.
    static std::string number(double value) {
        std::array<char, 32> digits{};
        std::string text(digits.data(),
                         std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
        const std::size_t exponent = text.find('e');
        if (exponent == std::string::npos) return text;
        const std::string sign = text[exponent + 1] == '-' ? "-" : "";
        return text.substr(0, exponent + 1) + sign + text.substr(text.find_first_not_of("+-0", exponent + 1));
    }
};

// The name of a field, with its range.
struct RangedName {
    const char* name;
    FieldRange range;

    constexpr operator const char*() const noexcept { return name; }
};

constexpr RangedName within(const char* name, double lowest, double highest) {
    return {name, {lowest, highest}};
}
constexpr RangedName above(const char* name, double bound, double highest) {
    return {name, {.lowest = bound, .highest = highest, .lowest_allowed = false}};
}
constexpr RangedName below(const char* name, double lowest, double bound) {
    return {name, {.lowest = lowest, .highest = bound, .highest_allowed = false}};
}

}  // namespace afferent
