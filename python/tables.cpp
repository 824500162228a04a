// Tables as they come: what they are taken for, and a scene that runs on them.
#include <array>
#include <cmath>
#include <memory>

#include "afferent/io/files/table.hpp"
#include "afferent/python/bindings.hpp"
#include "afferent/studies/inspect.hpp"

namespace afferent::python {
namespace {

using Path = std::filesystem::path;

// The arguments by their names, as Python's functions have checked them.
struct TableArguments {
    std::vector<std::string> columns;
    std::string time_column;
    std::string time_unit;  // "s", "ms", ...; empty: to be found
    std::optional<double> rate_hz;
    std::optional<double> begin_s;
    std::string missing;
};

TableOptions table_options_of(const TableArguments& arguments) {
    TableOptions options{
        .columns = arguments.columns, .time_column = arguments.time_column, .rate_hz = arguments.rate_hz};
    if (!arguments.time_unit.empty()) {
        const auto unit = arguments.time_unit == "day-first"     ? TimeUnit::day_first
                          : arguments.time_unit == "month-first" ? TimeUnit::month_first
                                                                 : time_unit_called(arguments.time_unit);
        if (!unit)
            throw py::value_error("time_unit must be s, ms, us, ns, min, day-first or month-first, is " +
                                  arguments.time_unit);
        options.time_unit = *unit;
    }
    if (arguments.begin_s) options.begin = from_seconds(*arguments.begin_s);
    if (arguments.missing == "skip")
        options.missing = Missing::skip;
    else if (arguments.missing == "interpolate")
        options.missing = Missing::interpolate;
    else if (arguments.missing != "refuse")
        throw py::value_error("missing must be refuse, skip or interpolate, is " + arguments.missing);
    return options;
}

scene::TableUnit table_unit(const std::string& name) {
    if (name.empty()) return scene::TableUnit::by_name;
    if (name == "n") return scene::TableUnit::newtons;
    if (name == "counts") return scene::TableUnit::counts;
    if (name == "v") return scene::TableUnit::volts;
    throw py::value_error("unit must be n, counts or v, is " + name);
}

// Names of columns, times in ns and the values, a row for each time; the arrays keep the table.
py::tuple arrays_of(std::shared_ptr<Table> table) {
    Table& rows = *table;
    const py::capsule owner = owner_of(std::make_unique<std::shared_ptr<Table>>(std::move(table)));
    static_assert(sizeof(TimePoint) == sizeof(std::int64_t));
    const std::size_t columns = rows.columns.size();
    return py::make_tuple(rows.columns,
                          py::array(py::dtype::of<std::int64_t>(), {rows.rows()}, {sizeof(TimePoint)},
                                    rows.times.data(), owner),
                          py::array(py::dtype::of<double>(), {rows.rows(), columns},
                                    {columns * sizeof(double), sizeof(double)}, rows.values.data(), owner));
}

py::tuple read_table_of(const Path& file, const TableArguments& arguments) {
    std::shared_ptr<Table> table;
    const TableOptions options = table_options_of(arguments);
    {
        const py::gil_scoped_release unlocked;
        auto read = read_table(file, options);
        if (const auto* error = std::get_if<TableError>(&read))
            throw OutsideError({Error::Kind::malformed, error->message()});
        table = std::make_shared<Table>(std::get<Table>(std::move(read)));
    }
    return py::make_tuple(arrays_of(table), table->format.sentences());
}

const char* use_name(ColumnInspection::Use use) {
    constexpr std::array names{"grip force", "force", "emg", "not used"};
    return names[static_cast<std::size_t>(use)];
}

py::dict inspected(const Path& file, const TableArguments& arguments, const std::string& unit,
                   const std::vector<std::pair<double, double>>& calibration,
                   std::optional<double> newtons_per_volt, std::optional<double> reference_v) {
    InspectionOptions options{.table = table_options_of(arguments), .unit = table_unit(unit)};
    for (const auto& [value, force_n] : calibration) options.calibration.push_back({value, force_n});
    options.newtons_per_volt = newtons_per_volt;
    options.reference_v = reference_v;
    std::optional<TableInspection> found;
    {
        const py::gil_scoped_release unlocked;
        found = value_or_throw(inspect_table(file, options));
    }
    py::list columns;
    for (const ColumnInspection& column : found->columns)
        columns.append(py::make_tuple(column.name, use_name(column.use), column.unit, column.reason,
                                      column.lowest, column.highest, column.median));
    py::list gaps;
    for (const TableInspection::Gap& gap : found->longest_gaps)
        gaps.append(py::make_tuple(seconds(gap.begin), seconds(gap.length)));
    py::dict result;
    result["file"] = found->table.file;
    result["columns"] = columns;
    result["sentences"] = found->sentences;
    result["assumptions"] = found->assumptions;
    result["rate_hz"] = found->rate_hz;
    result["length_s"] = seconds(found->length);
    result["gaps"] = found->gaps;
    result["longest_gaps_s"] = gaps;
    result["scene"] = found->scene;
    result["why_no_scene"] = found->why_no_scene;
    result["table"] = arrays_of(std::make_shared<Table>(std::move(found->table)));
    return result;
}

}  // namespace

void bind_tables(py::module_& module) {
    py::class_<TableArguments>(module, "TableOptions")
        .def(py::init([](std::vector<std::string> columns, std::string time_column, std::string time_unit,
                         std::optional<double> rate_hz, std::optional<double> begin_s, std::string missing) {
                 return TableArguments{
                     std::move(columns), std::move(time_column), std::move(time_unit), rate_hz, begin_s,
                     std::move(missing)};
             }),
             py::arg("columns"), py::arg("time_column"), py::arg("time_unit"), py::arg("rate_hz"),
             py::arg("begin_s"), py::arg("missing"));
    module.def("read_table", read_table_of, py::arg("file"), py::arg("options"));
    module.def("inspect_table", inspected, py::arg("file"), py::arg("options"), py::arg("unit"),
               py::arg("calibration"), py::arg("newtons_per_volt"), py::arg("reference_v"));
}

}  // namespace afferent::python
