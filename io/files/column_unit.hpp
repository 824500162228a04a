// The unit of a table's column, by its name.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace afferent {

// "F1 [mN]", "F1 (mN)", "F1/mN", "F1 in mN", "F1 mN" and "f1_mn" are all F1 in millinewtons; the name is in
// lower case.
struct NamedUnit {
    std::string name;
    std::string unit;  // empty: none is said
};
NamedUnit named_unit(std::string_view column);

// A unit as it stands alone, under a column's name: "[mN]" and " mN " are "mN".
std::string_view unit_alone(std::string_view text);
// In lower case: of force, counts, volts, time or mass.
bool is_known_unit(std::string_view unit);

// A mass is no force; its weight on Earth may be meant. How many newtons that is for one of the unit.
std::optional<double> weight_n(std::string_view unit);
// What to do about a column of masses; empty: it is none.
std::string said_of_mass(std::string_view column);

enum class Quantity { force, counts, volts };

// What a unit measures, and how many newtons, counts or volts it is.
struct ValueUnit {
    Quantity quantity;
    double factor;
};
// Nothing for a unit that is not known, and for a mass, which is no force: g, kg.
std::optional<ValueUnit> value_unit(std::string_view unit);
inline std::optional<ValueUnit> unit_of_column(std::string_view column) {
    return value_unit(named_unit(column).unit);
}

// "newtons", "counts", "volts".
const char* unit_name(Quantity quantity) noexcept;

}  // namespace afferent
