#include "afferent/nodes/table_columns.hpp"

#include <algorithm>
#include <utility>

namespace afferent {
namespace {

std::string joined(const std::vector<std::string>& names) {
    constexpr std::size_t most = 12;
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), most); ++i) text += (i == 0 ? "" : ", ") + names[i];
    return names.size() > most ? text + ", …" : text;
}

// What to do about a column that is of neither force nor counts nor volts.
std::string advice(const std::string& column) {
    if (const std::string mass = said_of_mass(column); !mass.empty()) return mass;
    return "rename \"" + column +
           "\" if it is in one of these, or say unit (--unit volts), or let the scene's table name the "
           "columns to read "
           "(--columns)";
}

std::optional<ValueUnit> unit_of(const std::string& name, scene::TableUnit otherwise) {
    const NamedUnit named = named_unit(name);
    if (const auto known = value_unit(named.unit)) return known;
    if (!named.unit.empty() || otherwise == scene::TableUnit::by_name) return std::nullopt;
    return ValueUnit{otherwise == scene::TableUnit::newtons  ? Quantity::force
                     : otherwise == scene::TableUnit::counts ? Quantity::counts
                                                             : Quantity::volts,
                     1};
}

}  // namespace

Result<TableColumns> table_columns(const std::vector<std::string>& names, scene::TableUnit unit) {
    TableColumns columns{Quantity::force, {}};
    const auto refuse = [&](const std::string& what) {
        return Error{Error::Kind::malformed,
                     "every column must be of force, as _n or [mN], or every one in _counts (of the "
                     "converter), or every "
                     "one in volts, as _v or [mV]; they are " +
                         joined(names) + what};
    };
    for (const std::string& name : names) {
        const auto known = unit_of(name, unit);
        if (!known) return refuse(": " + advice(name));
        if (columns.factors.empty()) columns.quantity = known->quantity;
        if (known->quantity != columns.quantity) return refuse("");
        columns.factors.push_back(known->factor);
    }
    return columns;
}

void volts_to_counts(TableColumns& columns, const Plan& plan) {
    if (columns.quantity != Quantity::volts) return;
    columns.quantity = Quantity::counts;
    for (const PatchPlan& patch : plan.patches) {
        if (!patch.owns_elements) continue;
        const double counts_per_volt = Sensor(patch.sensor).highest_count() / patch.sensor.reference_v;
        for (Address i = patch.first_element; i < patch.first_element + patch.elements(); ++i)
            if (i < columns.factors.size()) columns.factors[i] *= counts_per_volt;
    }
}

}  // namespace afferent
