#include "afferent/io/files/column_set.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>
#include <utility>

#include "afferent/io/files/column_unit.hpp"

namespace afferent {
namespace {

constexpr std::uint64_t column_set_format = 0x3174'6573'6c6f'6363;  // "ccolset1"
constexpr std::uint64_t most_columns = std::uint64_t{1} << 24U;

struct ColumnSetHead {
    std::uint64_t format = column_set_format;
    std::uint64_t rows = 0;
    std::uint64_t columns = 0;
    std::uint64_t name_bytes = 0;  // one name a line, that of time first
};

Error unfit(std::string text) { return {Error::Kind::malformed, std::move(text)}; }

std::string base_name(const std::string& path) { return path.substr(path.rfind('/') + 1); }

std::string folder_of(const std::string& path) { return path.substr(0, path.rfind('/') + 1); }

std::string numbered(const std::string& name, std::uint64_t number) {
    const std::string digits = std::to_string(number);
    if (name.empty()) return digits;
    if (name.ends_with(']') || name.ends_with(')')) {
        const std::size_t unit = name.find_last_of(name.ends_with(']') ? '[' : '(');
        if (unit != std::string::npos) return name.substr(0, unit) + digits + " " + name.substr(unit);
    }
    const std::string unit = named_unit(name).unit;
    if (unit.empty() || name.size() < unit.size() + 1) return name + "_" + digits;
    const std::size_t end = name.size() - unit.size() - 1;
    return name.substr(0, end) + "_" + digits + name.substr(end);
}

class ColumnChooser {
  public:
    ColumnChooser(const std::vector<NumberArray>& arrays, const TableOptions& options)
        : arrays_(arrays), options_(options) {}

    Result<ColumnSet> result() {
        if (!options_.rate_hz) {
            AFFERENT_TRY(find_time());
        }
        for (const std::string& wanted : options_.columns) {
            const auto [found, column] = find(wanted);
            if (!found)
                return unfit("there is no dataset of numbers \"" + wanted + "\"; there are " + listed());
            if (set_.rows == 0) set_.rows = found->rows;
            if (found->rows != set_.rows)
                return unfit("\"" + found->name + "\" has " + std::to_string(found->rows) + " rows, and " +
                             (set_.time.empty() ? "another dataset" : "\"" + set_.time + "\"") + " has " +
                             std::to_string(set_.rows));
            AFFERENT_TRY(take(*found, column));
        }
        if (options_.columns.empty())
            for (const NumberArray& array : arrays_) {
                if (set_.rows == 0) set_.rows = array.rows;
                if (array.name == time_ || array.rows != set_.rows) continue;
                AFFERENT_TRY(take(array));
            }
        if (set_.names.size() == (set_.time.empty() ? 0U : 1U))
            return unfit("there is no dataset of numbers that is as long as time; there are " + listed());
        return std::move(set_);
    }

  private:
    std::string listed() const {
        constexpr std::size_t most = 12;
        std::string list;
        for (std::size_t i = 0; i < std::min(arrays_.size(), most); ++i)
            list += (i == 0 ? "\"" : ", \"") + arrays_[i].name + "\" (" + std::to_string(arrays_[i].rows) +
                    " x " + std::to_string(arrays_[i].columns) + ")";
        return arrays_.empty() ? "none" : arrays_.size() > most ? list + ", …" : list;
    }

    Result<void> find_time() {
        std::vector<std::string> names;
        std::vector<const NumberArray*> single;
        TableOptions options = options_;
        options.time_column = base_name(options.time_column);
        for (const NumberArray& array : arrays_)
            if (array.columns == 1) {
                names.push_back(base_name(array.name));
                single.push_back(&array);
            }
        const auto found = find_time_column(names, options);
        if (const auto* refusal = std::get_if<std::string>(&found)) return unfit(*refusal);
        const TimeColumn& position = std::get<TimeColumn>(found);
        const NumberArray& time = *single[position.position];
        if (position.date_position)
            return unfit("\"" + single[*position.date_position]->name + "\" and \"" + time.name +
                         "\" may both be time: say which by time_column (--time-column)");
        time_ = time.name;
        set_.time = base_name(time.name);
        set_.rows = time.rows;
        return take(time);
    }

    // A dataset, or one column of it, counted from 1, by the name that it has as a column.
    std::pair<const NumberArray*, std::uint64_t> find(const std::string& wanted) const {
        for (const NumberArray& array : arrays_)
            if (array.name == wanted || base_name(array.name) == wanted) return {&array, 0};
        for (const NumberArray& array : arrays_)
            for (std::uint64_t column = 1; array.columns > 1 && column <= array.columns; ++column)
                if (numbered(base_name(array.name), column) == base_name(wanted) &&
                    (wanted.find('/') == std::string::npos || folder_of(wanted) == folder_of(array.name)))
                    return {&array, column};
        return {};
    }

    Result<void> take(const NumberArray& array, std::uint64_t only = 0) {
        if (array.rows == 0 || array.columns == 0 ||
            set_.values.size() + array.rows * array.columns > Table::most_values)
            return unfit("\"" + array.name + "\" is empty, or there are more than " +
                         std::to_string(Table::most_values) + " values");
        if (read_ != &array) {
            AFFERENT_TRY(values, array.read());
            values_ = std::move(values);
            read_ = &array;
        }
        for (std::uint64_t column = 0; column < array.columns; ++column) {
            if (only != 0 && column + 1 != only) continue;
            const std::string name = base_name(array.name);
            set_.names.push_back(array.columns == 1 && !name.empty() ? name : numbered(name, column + 1));
            for (std::uint64_t row = 0; row < array.rows; ++row)
                set_.values.push_back(values_[row * array.columns + column]);
        }
        return success();
    }

    const std::vector<NumberArray>& arrays_;
    const TableOptions& options_;
    std::string time_;
    const NumberArray* read_ = nullptr;  // whose values are these
    std::vector<double> values_;
    ColumnSet set_;
};

}  // namespace

std::vector<std::byte> to_bytes(const ColumnSet& set) {
    std::string names = set.time + '\n';
    for (const std::string& name : set.names) names += name + '\n';
    const ColumnSetHead head{.rows = set.rows, .columns = set.names.size(), .name_bytes = names.size()};
    std::vector<std::byte> bytes(sizeof head + names.size() + set.values.size() * sizeof(double));
    std::memcpy(bytes.data(), &head, sizeof head);
    std::memcpy(bytes.data() + sizeof head, names.data(), names.size());
    if (!set.values.empty())
        std::memcpy(bytes.data() + sizeof head + names.size(), set.values.data(),
                    set.values.size() * sizeof(double));
    return bytes;
}

Result<ColumnSet> column_set(std::span<const std::byte> bytes) {
    ColumnSetHead head;
    if (bytes.size() < sizeof head) return unfit("these are no columns");
    std::memcpy(&head, bytes.data(), sizeof head);
    bytes = bytes.subspan(sizeof head);
    if (head.format != column_set_format || head.columns == 0 || head.columns > most_columns ||
        head.rows == 0 || head.rows > Table::most_values / head.columns || head.name_bytes > bytes.size() ||
        bytes.size() - head.name_bytes != head.rows * head.columns * sizeof(double))
        return unfit("these are no columns, or not all of them");
    std::string_view names(reinterpret_cast<const char*>(bytes.data()), head.name_bytes);
    std::vector<std::string> lines;
    for (std::size_t end; (end = names.find('\n')) != std::string_view::npos; names.remove_prefix(end + 1))
        lines.emplace_back(names.substr(0, end));
    if (lines.size() != head.columns + 1) return unfit("these are no columns, or not all of their names");
    ColumnSet set{
        .names = {lines.begin() + 1, lines.end()}, .time = lines.front(), .rows = head.rows, .values = {}};
    set.values.resize(head.rows * head.columns);
    std::memcpy(set.values.data(), bytes.data() + head.name_bytes, set.values.size() * sizeof(double));
    return set;
}

Result<ColumnSet> columns_of(const std::vector<NumberArray>& arrays, const TableOptions& options) {
    return ColumnChooser(arrays, options).result();
}

std::variant<Table, TableError> table_of(const ColumnSet& set, const std::string& file,
                                         const TableOptions& options) {
    const auto refuse = [&](std::size_t row, const std::string& column, const std::string& text) {
        return TableError{file, 0, "row " + std::to_string(row + 1) + ": column \"" + column + "\": " + text};
    };
    Table table{.file = file, .columns = {}, .times = {}, .values = {}};
    std::vector<std::span<const double>> columns;
    std::optional<std::span<const double>> times;
    for (std::size_t i = 0; i < set.names.size(); ++i) {
        const auto values = std::span(set.values).subspan(i * set.rows, set.rows);
        if (!set.time.empty() && !times && set.names[i] == set.time) {
            times = values;
            continue;
        }
        table.columns.push_back(set.names[i]);
        columns.push_back(values);
    }
    std::optional<TableClock> clock;
    if (times) {
        const auto found =
            find_time_column({set.time}, {.time_column = set.time, .time_unit = options.time_unit});
        clock.emplace(set.time, std::get<TimeColumn>(found).unit, options);
    }
    bool first_waits = false;
    const auto keep = [&](std::size_t row, TimePoint time) {
        if (time < scene_start) return;
        table.times.push_back(time);
        for (const auto& column : columns) table.values.push_back(column[row]);
    };
    for (std::size_t row = 0; row < set.rows; ++row) {
        for (std::size_t i = 0; i < columns.size(); ++i)
            if (!std::isfinite(columns[i][row]))
                return refuse(row, table.columns[i], "a number is not finite");
        if (!clock) {
            keep(row, sample_time(row, options.rate_hz.value_or(1)));
            continue;
        }
        const double time = (*times)[row];
        std::array<char, 32> text{};
        std::snprintf(text.data(), text.size(), "%.17g", time);
        if (!std::isfinite(time)) return refuse(row, set.time, "a time is not finite");
        if (auto refusal = clock->take(time, text.data())) return refuse(row, set.time, *refusal);
        if (!clock->is_certain()) {
            first_waits = true;
            continue;
        }
        if (std::exchange(first_waits, false)) keep(0, clock->time_before());
        keep(row, clock->time());
    }
    if (first_waits) {
        if (auto refusal = clock->settle()) return refuse(0, set.time, *refusal);
        keep(0, clock->time());
    }
    if (table.times.empty())
        return TableError{file, 0, "all rows are before begin_s, where the scene begins"};
    if (clock) clock->fill_in(table.format);
    const std::string ending = std::filesystem::path(file).extension().string();
    table.format.container = ending == ".npz" ? "NPZ" : ending == ".npy" ? "NPY" : "HDF5";
    return table;
}

}  // namespace afferent
