#include "afferent/io/files/table.hpp"

#include <array>
#include <utility>

#include "afferent/io/files/table_input.hpp"
#include "afferent/io/files/table_reader.hpp"

namespace afferent {
namespace {

TableError too_long(const std::string& file, std::size_t most_values) {
    return {file, 0,
            "the table has more than " + std::to_string(most_values) + " values, for which " +
                std::to_string(most_values * sizeof(double) >> 20U) +
                " MB are needed; name fewer columns (--columns), or read a shorter part"};
}

TableError values_missing(const std::string& file, const TableFormat& format) {
    const bool has_lines = format.container.empty();
    return {file, has_lines ? format.missing.first_line : 0,
            format.missing.text(has_lines ? "line" : "row") +
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

struct Head {
    std::vector<std::string> columns;
    TableFormat format;
};

// Calls on_row(row) for each row, until it says that there are enough.
template <class OnRow>
std::variant<Head, TableError> read_rows(const std::filesystem::path& file, TableOptions options,
                                         const std::function<void(double)>& progress, const OnRow& on_row) {
    // To say how many values are missing, all rows are read, as if those were skipped.
    const bool refuses = options.missing == Missing::refuse;
    if (refuses) options.missing = Missing::skip;
    auto opened = TableInput::open(file, options);
    if (!opened) return table_error(file.string(), opened.error());
    TableInput& in = opened.value();
    if (in.scans) {
        const Table table = table_of_scans(*in.scans, file.string(), options.columns.front());
        for (std::size_t i = 0; i < table.rows() && on_row(TableRow{i + 1, table.times[i], table.row(i)});
             ++i) {
        }
        return Head{table.columns, table.format};
    }
    TableReader reader(file.string(), in.options());
    bool enough = false;
    const TableReader::OnRow take = [&](const TableRow& row) { enough = enough || !on_row(row); };
    std::array<char, 65536> bytes;
    std::optional<TableError> error;
    while (!error && !enough) {
        const auto size = in.read(bytes);
        if (!size) return table_error(file.string(), size.error());
        if (progress) progress(in.fraction());
        if (size.value() == 0) break;
        error = reader.feed({bytes.data(), size.value()}, take);
    }
    if (!error && !enough) error = reader.finish(take);
    Head head{reader.columns(), reader.format()};
    in.complete(head.format);
    if (refuses && head.format.missing.rows != 0) return values_missing(file.string(), head.format);
    if (error) return in.place(std::move(*error));
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

std::variant<Table, TableError> read_table(const std::filesystem::path& file, TableOptions options,
                                           const TableLimits& limits) {
    Table table{.file = file.string(), .columns = {}, .times = {}, .values = {}};
    bool full = false;
    const auto keep = [&](const TableRow& row) {
        full = full || table.values.size() + table.times.size() + row.values.size() + 1 > limits.most_values;
        if (full) return false;
        table.times.push_back(row.time);
        table.values.insert(table.values.end(), row.values.begin(), row.values.end());
        return true;
    };
    auto read = read_rows(file, std::move(options), limits.progress, keep);
    if (auto* error = std::get_if<TableError>(&read)) return std::move(*error);
    if (full && (!limits.cuts || table.times.empty())) return too_long(file.string(), limits.most_values);
    auto& head = std::get<Head>(read);
    table.columns = std::move(head.columns);
    table.format = std::move(head.format);
    table.format.is_cut = full;
    return table;
}

std::variant<TableSpan, TableError> read_span(const std::filesystem::path& file, TableOptions options,
                                              const std::function<void(double)>& progress) {
    TableSpan span;
    const auto count = [&span](const TableRow& row) {
        if (span.rows++ == 0) span.first = row.time;
        span.last = row.time;
        return true;
    };
    auto read = read_rows(file, std::move(options), progress, count);
    if (auto* error = std::get_if<TableError>(&read)) return std::move(*error);
    span.format = std::move(std::get<Head>(read).format);
    return span;
}

}  // namespace afferent
