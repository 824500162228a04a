#include "afferent/io/files/missing_values.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace afferent {

void MissingValues::count(std::size_t line, std::string_view column) {
    if (values++ > 0) return;
    first_line = line;
    first_column = column;
}

std::string MissingValues::text(std::string_view line) const {
    return std::to_string(values) + (values == 1 ? " value is" : " values are") + " missing in " +
           std::to_string(rows) + (rows == 1 ? " row" : " rows") + ", the first of column \"" + first_column +
           "\" in " + std::string(line) + " " + std::to_string(first_line);
}

bool stands_for_nothing(std::string_view field) noexcept {
    constexpr std::array<std::string_view, 7> words{"nan", "-nan", "na", "n/a", "#n/a", "null", "none"};
    if (field.find_first_not_of('-') == std::string_view::npos) return true;
    return std::ranges::any_of(words, [field](std::string_view word) {
        return std::ranges::equal(field, word, {}, [](char c) {
            return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
        });
    });
}

std::optional<std::string> RowCompleter::take(const TableRow& row, const OnRow& on_row) {
    const bool complete = std::ranges::none_of(row.values, [](double value) { return std::isnan(value); });
    if (rule_ != Missing::interpolate) {
        if (complete) on_row(row);
        return std::nullopt;
    }
    columns_.resize(row.values.size());
    for (std::size_t i = 0; i < columns_.size(); ++i)
        if (!std::isnan(row.values[i])) fill(i, row.time, row.values[i]);
    if (complete && waiting_.empty()) {
        on_row(row);
        return std::nullopt;
    }
    waiting_.push_back({row.line, row.time, {row.values.begin(), row.values.end()}});
    for (std::size_t i = 0; i < columns_.size(); ++i)
        if (std::isnan(row.values[i])) ++columns_[i].gap;
    const auto longest = std::ranges::max(columns_, {}, &Column::gap).gap;
    for (; waiting_.size() > longest; waiting_.pop_front())
        on_row({waiting_.front().line, waiting_.front().time, waiting_.front().values});
    if (waiting_.size() * columns_.size() <= most_waiting) return std::nullopt;
    return "a value has been missing for " + std::to_string(waiting_.size()) +
           " rows, too many for a straight line: leave its column out (--columns), or the rows (--missing "
           "skip)";
}

// The rows that lack this column's value are the last that wait.
void RowCompleter::fill(std::size_t column, TimePoint time, double value) {
    Column& of = columns_[column];
    for (auto row = waiting_.end() - static_cast<std::ptrdiff_t>(of.gap); row != waiting_.end(); ++row)
        row->values[column] =
            of.value ? std::lerp(*of.value, value, seconds(row->time - of.time) / seconds(time - of.time))
                     : value;
    of = {value, time, 0};
}

std::optional<std::string> RowCompleter::finish(const OnRow& on_row) {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
        if (columns_[i].gap == 0) continue;
        if (!columns_[i].value) return "a column has no value at all: leave it out (--columns)";
        for (auto row = waiting_.end() - static_cast<std::ptrdiff_t>(columns_[i].gap); row != waiting_.end();
             ++row)
            row->values[i] = *columns_[i].value;
    }
    for (const Waiting& row : std::exchange(waiting_, {})) on_row({row.line, row.time, row.values});
    return std::nullopt;
}

}  // namespace afferent
