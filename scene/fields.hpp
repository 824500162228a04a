// The fields of a scene's structs, each stated once beside the members. Included by the headers of the scene;
// readers, writers and comparisons walk over the fields.
#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <string>
#include <type_traits>
#include <variant>

#include "afferent/runtime/overloaded.hpp"

namespace afferent {

// A struct of a scene states the names of its members, as in the text, and the range of each number:
//
//     struct Tcp {
//         static constexpr const char* alternative = "tcp";  // its name, where a variant of the scene has it
//         std::string host = "127.0.0.1";
//         std::uint32_t port = 7450;
//         bool operator==(const Tcp&) const = default;
//         static void fields(auto& self, auto&& f) {
//             f("host", self.host);
//             f(within("port", 0, 65535), self.port);
//         }
//     };
//
// f.arms(self.transport) declares a variant whose alternatives are fields of the struct itself. An
// alternative without a name has no message of its own: its fields belong to the surrounding message. Structs
// of other folders have an each_field() instead, beside the topic that contains them.

template <class Self, class T>
concept Is = std::same_as<std::remove_const_t<Self>, T>;

// Calls f(name, member) for each field of the struct.
template <class Self, class F>
requires requires(Self& self, F&& f) { Self::fields(self, f); }
void each_field(Self& self, F&& f) { Self::fields(self, f); }

// The names of a variant's alternatives, in order.
template <class Variant>
inline constexpr std::array<const char*, 0> alternative_names{};
template <class... A>
inline constexpr std::array<const char*, sizeof...(A)> alternative_names<std::variant<A...>>{
    A::alternative...};

// The range of a number.
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
    // The shortest decimal form, without sign and leading zeros in the exponent.
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

// The name of a number, with its range.
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

namespace scene {

// The largest number of elements of a scene, and of its afferents.
inline constexpr std::uint32_t most_addresses = 1U << 24;

}  // namespace scene
}  // namespace afferent
