#include "afferent/io/files/table.hpp"

#include <array>
#include <utility>

#include "afferent/io/files/hdf5_process.hpp"
#include "afferent/io/files/sibling_program.hpp"
#include "afferent/io/files/table_reader.hpp"
#include "afferent/io/files/text_input.hpp"

namespace afferent {
namespace {

TableError too_long(const std::string& file) {
    return {file, 0,
            "the table has more than " + std::to_string(Table::most_values) +
                " values; name fewer columns (--columns)"};
}

TableError values_missing(const std::string& file, const MissingValues& missing) {
    return {file, missing.first_line,
            missing.text() +
                ". To leave such rows out: --missing skip; to draw straight lines over them: --missing "
                "interpolate (in "
                "a scene: table { missing: SKIP }); to read other columns: --columns"};
}

// The message begins with the file's name, as a TableError's does.
TableError table_error(const std::string& file, const Error& error) {
    return {file, 0, error.text.starts_with(file + ": ") ? error.text.substr(file.size() + 2) : error.text};
}

// Scans are a column for each of their values.
Table table_of_scans(const ScanSet& scans, const std::string& file, const std::string& dataset) {
    Table table{.file = file, .columns = {}, .times = {}, .values = {}};
    const std::size_t columns = scans.rows() * scans.columns();
    const std::size_t unit = dataset.rfind('_');
    for (std::size_t i = 1; i <= columns; ++i)
        table.columns.push_back(dataset.substr(0, unit) + "_" + std::to_string(i) +
                                (unit == std::string::npos ? "" : dataset.substr(unit)));
    table.values.resize(scans.scans() * columns);
    for (std::size_t i = 0; i < scans.scans(); ++i) {
        table.times.push_back(scene_start + rounded(Seconds(scans.time_s(i))));
        scans.copy(i, std::span(table.values).subspan(i * columns, columns));
    }
    table.format.container = "HDF5";
    table.format.time_column = "time_s";
    return table;
}

std::variant<Table, TableError> read_container(const std::filesystem::path& file,
                                               const TableOptions& options) {
    auto read = Hdf5Process(sibling_program("afferent-hdf5")).read_table(file, options);
    if (!read) return table_error(file.string(), read.error());
    if (const auto* columns = std::get_if<ColumnSet>(&read.value()))
        return table_of(*columns, file.string(), options);
    return table_of_scans(std::get<ScanSet>(read.value()), file.string(), options.columns.front());
}

struct Head {
    std::vector<std::string> columns;
    TableFormat format;
};

// Calls on_row(row) for each row, until it says that there are too many.
template <class OnRow>
std::variant<Head, TableError> read_rows(const std::filesystem::path& file, TableOptions options,
                                         const OnRow& on_row) {
    if (is_container(file)) {
        auto read = read_container(file, options);
        if (auto* error = std::get_if<TableError>(&read)) return std::move(*error);
        auto& table = std::get<Table>(read);
        for (std::size_t i = 0; i < table.rows(); ++i) on_row(TableRow{i + 1, table.times[i], table.row(i)});
        return Head{std::move(table.columns), std::move(table.format)};
    }
    auto in = TextInput::open(file);
    if (!in) return table_error(file.string(), in.error());
    // To say how many values are missing, all rows are read, as if those were skipped.
    const bool refuses = options.missing == Missing::refuse;
    if (refuses) options.missing = Missing::skip;
    TableReader reader(file.string(), std::move(options));
    bool full = false;
    const TableReader::OnRow take = [&](const TableRow& row) { full = !on_row(row) || full; };
    std::array<char, 65536> bytes;
    for (;;) {
        const auto size = in.value().read(bytes);
        if (!size) return table_error(file.string(), size.error());
        if (size.value() == 0) break;
        if (auto error = reader.feed({bytes.data(), size.value()}, take)) return std::move(*error);
        if (full) return too_long(file.string());
    }
    auto error = reader.finish(take);
    const MissingValues missing = reader.format().missing;
    if (refuses && missing.rows != 0) return values_missing(file.string(), missing);
    if (error) return std::move(*error);
    Head head{reader.columns(), reader.format()};
    head.format.compressed = in.value().compressed();
    return head;
}

}  // namespace

Duration TableSpan::length() const noexcept {
    const Duration to_last = last - scene_start;
    return rows < 2 ? to_last : to_last + (last - first) / static_cast<std::int64_t>(rows - 1);
}

TableSpan Table::span() const {
    if (times.empty()) return {.format = format};
    return {.first = times.front(), .last = times.back(), .rows = rows(), .format = format};
}

bool is_container(const std::filesystem::path& file) {
    const std::string ending = file.extension().string();
    return ending == ".h5" || ending == ".hdf5" || ending == ".npz" || ending == ".npy";
}

std::variant<Table, TableError> read_table(const std::filesystem::path& file, TableOptions options) {
    Table table{.file = file.string(), .columns = {}, .times = {}, .values = {}};
    const auto keep = [&table](const TableRow& row) {
        if (table.values.size() > Table::most_values) return false;
        table.times.push_back(row.time);
        table.values.insert(table.values.end(), row.values.begin(), row.values.end());
        return true;
    };
    auto read = read_rows(file, std::move(options), keep);
    if (auto* error = std::get_if<TableError>(&read)) return std::move(*error);
    auto& head = std::get<Head>(read);
    table.columns = std::move(head.columns);
    table.format = std::move(head.format);
    return table;
}

std::variant<TableSpan, TableError> read_span(const std::filesystem::path& file, TableOptions options) {
    TableSpan span;
    const auto count = [&span](const TableRow& row) {
        if (span.rows++ == 0) span.first = row.time;
        span.last = row.time;
        return true;
    };
    auto read = read_rows(file, std::move(options), count);
    if (auto* error = std::get_if<TableError>(&read)) return std::move(*error);
    span.format = std::move(std::get<Head>(read).format);
    return span;
}

}  // namespace afferent
