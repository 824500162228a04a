#include "afferent/apps/table_choice.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "afferent/apps/failure.hpp"

namespace afferent {
namespace {

template <class T, std::size_t n>
T choice(const char* option, const std::array<std::pair<std::string_view, T>, n>& choices,
         const std::string& given) {
    std::string allowed;
    for (const auto& [name, value] : choices) {
        if (name == given) return value;
        allowed += (allowed.empty() ? "" : ", ") + std::string(name);
    }
    throw Failure(std::string(option) + ": must be one of " + allowed + ", is " + given);
}

constexpr std::array<std::pair<std::string_view, TimeUnit>, 8> time_units{
    {{"s", TimeUnit::seconds},
     {"ms", TimeUnit::milliseconds},
     {"us", TimeUnit::microseconds},
     {"ns", TimeUnit::nanoseconds},
     {"min", TimeUnit::minutes},
     {"date", TimeUnit::date},
     {"day-first", TimeUnit::day_first},
     {"month-first", TimeUnit::month_first}}};
constexpr std::array<std::pair<std::string_view, Missing>, 3> missing_values{
    {{"refuse", Missing::refuse}, {"skip", Missing::skip}, {"interpolate", Missing::interpolate}}};
constexpr std::array<std::pair<std::string_view, scene::TableUnit>, 3> units{
    {{"newtons", scene::TableUnit::newtons},
     {"counts", scene::TableUnit::counts},
     {"volts", scene::TableUnit::volts}}};

// A name that has a comma in it stands in quotation marks: F1,"Force, left".
std::vector<std::string> names_in(const std::string& list) {
    std::vector<std::string> names(1);
    bool quoted = false;
    for (const char c : list) {
        if (c == '"')
            quoted = !quoted;
        else if (c == ',' && !quoted)
            names.emplace_back();
        else
            names.back() += c;
    }
    if (std::ranges::any_of(names, &std::string::empty))
        throw Failure("--columns: must be names separated by commas, is " + list);
    return names;
}

}  // namespace

std::vector<Option> TableChoice::options() {
    return {
        option("--columns", columns, "Columns of the table to read, separated by commas: F1,F2"),
        option("--time-column", time_column, "Its column of time"),
        option("--time-unit", time_unit,
               "What that is in: s, ms, us, ns, min or date; day-first or month-first for 03/04/2026"),
        option("--rate-hz", rate_hz, "Its rows have no time, and so many of them are a second").positive(),
        option("--begin-s", begin_s, "The time of the table at which the scene begins"),
        option("--missing", missing,
               "What to do where a value is missing: refuse, skip (its row) or interpolate"),
        option("--unit", unit, "What columns are in whose names have no unit: newtons, counts or volts"),
    };
}

bool TableChoice::given() const {
    return !columns.empty() || !time_column.empty() || !time_unit.empty() || !unit.empty() ||
           !missing.empty() || rate_hz || begin_s;
}

void TableChoice::apply(scene::Table& table) const {
    if (!columns.empty()) table.column = names_in(columns);
    if (!time_column.empty()) table.time_column = time_column;
    if (!time_unit.empty()) table.time_unit = choice("--time-unit", time_units, time_unit);
    if (!unit.empty()) table.unit = choice("--unit", units, unit);
    if (!missing.empty()) table.missing = choice("--missing", missing_values, missing);
    if (rate_hz) table.rate_hz = rate_hz;
    if (begin_s) table.begin_s = begin_s;
}

void TableChoice::apply(scene::Source& source) const {
    if (!given()) return;
    if (scene::Table* const table = force_table(source)) return apply(*table);
    auto* const input = std::get_if<scene::StandardInput>(&source);
    if (!input || rate_hz || begin_s)
        throw Failure(
            input ? "--rate-hz and --begin-s are for tables in files, and the scene reads standard input"
                  : "--columns, --time-column, --time-unit, --rate-hz, --begin-s, --missing and --unit are "
                    "for tables, and "
                    "the scene reads none; name one by --table");
    scene::Table table{.column = input->column,
                       .time_column = input->time_column,
                       .time_unit = input->time_unit,
                       .unit = input->unit,
                       .missing = input->missing};
    apply(table);
    input->column = table.column;
    input->time_column = table.time_column;
    input->time_unit = table.time_unit;
    input->unit = table.unit;
    input->missing = table.missing;
}

}  // namespace afferent
