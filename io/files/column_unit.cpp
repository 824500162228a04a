#include "afferent/io/files/column_unit.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "afferent/io/files/time_unit.hpp"

namespace afferent {
namespace {

struct KnownUnit {
    std::string_view unit;
    ValueUnit is;
};
constexpr std::array known_units{KnownUnit{"n", {Quantity::force, 1}},
                                 KnownUnit{"newton", {Quantity::force, 1}},
                                 KnownUnit{"newtons", {Quantity::force, 1}},
                                 KnownUnit{"mn", {Quantity::force, 1e-3}},
                                 KnownUnit{"kn", {Quantity::force, 1e3}},
                                 KnownUnit{"gf", {Quantity::force, 0.00980665}},
                                 KnownUnit{"kgf", {Quantity::force, 9.80665}},
                                 KnownUnit{"lbf", {Quantity::force, 4.4482216152605}},
                                 KnownUnit{"counts", {Quantity::counts, 1}},
                                 KnownUnit{"count", {Quantity::counts, 1}},
                                 KnownUnit{"lsb", {Quantity::counts, 1}},
                                 KnownUnit{"adc", {Quantity::counts, 1}},
                                 KnownUnit{"v", {Quantity::volts, 1}},
                                 KnownUnit{"volt", {Quantity::volts, 1}},
                                 KnownUnit{"volts", {Quantity::volts, 1}},
                                 KnownUnit{"mv", {Quantity::volts, 1e-3}},
                                 KnownUnit{"uv", {Quantity::volts, 1e-6}},
                                 KnownUnit{"\xC2\xB5v", {Quantity::volts, 1e-6}},
                                 KnownUnit{"\xCE\xBCv", {Quantity::volts, 1e-6}},
                                 KnownUnit{"\xB5v", {Quantity::volts, 1e-6}}};

std::string_view trimmed(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(" \t");
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

constexpr std::array<std::pair<std::string_view, double>, 6> masses{{{"g", 0.00980665},
                                                                     {"gram", 0.00980665},
                                                                     {"grams", 0.00980665},
                                                                     {"kg", 9.80665},
                                                                     {"lb", 4.4482216152605},
                                                                     {"oz", 0.27801385095378}}};

std::string in_lower_case(std::string_view text) {
    std::string lower(text);
    // In no locale: bytes of other alphabets stay.
    std::ranges::transform(lower, lower.begin(), [](char c) {
        return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    });
    return lower;
}

NamedUnit in_brackets(const std::string& lower, char open) {
    const std::size_t begin = lower.rfind(open);
    if (begin == std::string::npos) return {lower, ""};
    const std::string_view text = lower;
    return {std::string(trimmed(text.substr(0, begin))),
            std::string(trimmed(text.substr(begin + 1, text.size() - begin - 2)))};
}

}  // namespace

NamedUnit named_unit(std::string_view column) {
    const std::string lower = in_lower_case(trimmed(column));
    if (lower.ends_with(']')) return in_brackets(lower, '[');
    if (lower.ends_with(')')) return in_brackets(lower, '(');
    const std::size_t before = lower.find_last_of("_/ ");
    if (before == std::string::npos || !is_known_unit(std::string_view(lower).substr(before + 1)))
        return {lower, ""};
    std::string_view name = trimmed(std::string_view(lower).substr(0, before));
    if (name.ends_with(" in")) name = trimmed(name.substr(0, name.size() - 3));
    return {std::string(name), lower.substr(before + 1)};
}

std::string_view unit_alone(std::string_view text) {
    text = trimmed(text);
    if (text.size() > 2 &&
        ((text.front() == '[' && text.back() == ']') || (text.front() == '(' && text.back() == ')')))
        text = trimmed(text.substr(1, text.size() - 2));
    return text;
}

bool is_known_unit(std::string_view unit) {
    return value_unit(unit) || time_unit_called(unit) || weight_n(unit);
}

std::optional<double> weight_n(std::string_view unit) {
    const auto* const found = std::ranges::find(masses, unit, &std::pair<std::string_view, double>::first);
    return found == masses.end() ? std::nullopt : std::optional(found->second);
}

std::optional<ValueUnit> value_unit(std::string_view unit) {
    const auto* const known = std::ranges::find(known_units, unit, &KnownUnit::unit);
    return known == known_units.end() ? std::nullopt : std::optional(known->is);
}

std::string said_of_mass(std::string_view column) {
    const NamedUnit named = named_unit(column);
    const auto factor = weight_n(named.unit);
    if (!factor) return "";
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.8g", *factor);
    const std::string name(trimmed(column.substr(0, named.name.size())));
    const bool has_weight = value_unit(named.unit + "f").has_value();
    return named.unit + " is a mass: multiply \"" + std::string(column) + "\" by " + text.data() +
           " and call it \"" + name + "_n\"" +
           (has_weight ? ", or, if it is weights, call it \"" + name + " [" + named.unit + "f]\"" : "");
}

const char* unit_name(Quantity quantity) noexcept {
    return quantity == Quantity::force ? "newtons" : quantity == Quantity::counts ? "counts" : "volts";
}

}  // namespace afferent
