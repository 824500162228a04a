#include "afferent/io/files/hdf5_columns.hpp"

#include <algorithm>

#include "afferent/io/files/column_unit.hpp"
#include "afferent/io/files/hdf5.hpp"

namespace afferent {
namespace {

constexpr std::size_t most_datasets = 1000;

// The folder of a path, with its last slash; empty for the root.
std::string group_of(const std::string& path) { return path.substr(0, path.rfind('/') + 1); }

std::uint64_t product_of_others(const std::vector<hsize_t>& dimensions) {
    return dimensions.size() == 2 ? dimensions[1] : 1;
}

}  // namespace

bool has_scans(const std::filesystem::path& file, const std::string& dataset) {
    const hdf5::Quiet quiet;
    const auto opened = hdf5::open_file(file);
    if (!opened) return true;  // whose error it is
    const auto numbers = hdf5::open_numbers(opened.value().id(), dataset, 1, 3, Table::most_values);
    if (!numbers) return true;
    const std::size_t dimensions = numbers.value().dimensions.size();
    if (dimensions != 2) return dimensions == 3;
    const std::string unit = named_unit(dataset).unit;
    if (!dataset.ends_with("_n") && !dataset.ends_with("_counts") && !unit.empty()) return false;
    if (hdf5::number_attribute(numbers.value().data.id(), "rate_hz")) return true;
    // Without any time of its own its error is that of scans.
    const auto names = hdf5::numbers_in(opened.value().id(), group_of(dataset), most_datasets);
    if (!names) return true;
    return find_time_column(names.value(), {}).index() == 1 ||
           std::ranges::find(names.value(), "time_s") != names.value().end();
}

Result<ColumnSet> read_hdf5_columns(const std::filesystem::path& file, const TableOptions& options) {
    const hdf5::Quiet quiet;
    AFFERENT_TRY(opened, hdf5::open_file(file));
    const std::string group =
        group_of(options.columns.empty() ? options.time_column : options.columns.front());
    AFFERENT_TRY(names, hdf5::numbers_in(opened.id(), group, most_datasets));
    std::vector<NumberArray> arrays;
    for (const std::string& name : names) {
        const std::string path = group + name;
        const auto numbers = hdf5::open_numbers(opened.id(), path, 1, 2, Table::most_values);
        if (!numbers || name.find('\n') != std::string::npos) continue;
        const std::uint64_t rows = numbers.value().dimensions[0];
        const std::uint64_t columns = product_of_others(numbers.value().dimensions);
        arrays.push_back({.name = path,
                          .rows = rows,
                          .columns = columns,
                          .read = [&opened = opened, path, rows, columns]() -> Result<std::vector<double>> {
                              AFFERENT_TRY(found,
                                           hdf5::open_numbers(opened.id(), path, 1, 2, Table::most_values));
                              std::vector<double> values(rows * columns);
                              AFFERENT_TRY(found.read_all(values));
                              return values;
                          }});
    }
    return columns_of(arrays, options);
}

}  // namespace afferent
