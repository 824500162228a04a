#include "afferent/io/files/hdf5_columns.hpp"

#include <algorithm>
#include <memory>

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

constexpr std::size_t deepest_group = 4;
constexpr std::size_t most_groups = 100;

// This group and those below it that have datasets of numbers.
void find_groups(hid_t group, const std::string& path, std::size_t depth, std::vector<DatasetGroup>& found) {
    auto numbers = hdf5::numbers_in(group, "", most_datasets);
    if (numbers && !numbers.value().empty()) found.push_back({path, std::move(numbers.value())});
    const auto inner = hdf5::groups_in(group, most_datasets);
    if (!inner || depth == 0) return;
    for (const std::string& name : inner.value()) {
        if (found.size() > most_groups) return;
        if (const auto opened = hdf5::open_group(group, name))
            find_groups(opened.value().id(), path + name + "/", depth - 1, found);
    }
}

}  // namespace

bool has_scans(const std::filesystem::path& file, const std::string& dataset) {
    const hdf5::Quiet quiet;
    const auto opened = hdf5::open_file(file);
    if (!opened) return true;  // whose error it is
    const auto numbers = hdf5::open_numbers(opened.value().id(), dataset, 1, 3, most_numbers);
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

Result<void> send_hdf5_columns(const std::filesystem::path& file, const TableOptions& options,
                               const SendPiece& send) {
    const hdf5::Quiet quiet;
    AFFERENT_TRY(opened, hdf5::open_file(file));
    std::string group = asked_group(options);
    auto names = hdf5::numbers_in(opened.id(), group, most_datasets);
    if (!names || names.value().empty()) {
        std::vector<DatasetGroup> groups;
        find_groups(opened.id(), "", deepest_group, groups);
        AFFERENT_TRY(other, group_of_table(group, groups));
        group = std::move(other);
        names = hdf5::numbers_in(opened.id(), group, most_datasets);
    }
    if (!names) return names.error();
    std::vector<NumberArray> arrays;
    for (const std::string& name : names.value()) {
        const std::string path = group + name;
        auto numbers = hdf5::open_numbers(opened.id(), path, 1, 2, most_numbers);
        if (!numbers || name.find('\n') != std::string::npos) continue;
        auto dataset = std::make_shared<hdf5::Numbers>(std::move(numbers.value()));
        arrays.push_back({.name = path,
                          .rows = dataset->dimensions[0],
                          .columns = product_of_others(dataset->dimensions),
                          .read = [dataset](std::uint64_t first, std::span<double> values) {
                              return dataset->read(first, values);
                          }});
    }
    return send_columns(std::move(arrays), options, send);
}

}  // namespace afferent
