#include "afferent/io/files/column_text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "afferent/io/files/column_unit.hpp"

namespace afferent {
namespace {

// The numbers that are read at once.
constexpr std::uint64_t numbers_at_once = std::uint64_t{1} << 17U;
constexpr std::uint64_t most_columns = std::uint64_t{1} << 20U;

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

// A name as a field of the header, in which no control characters stand.
std::string quoted(const std::string& name) {
    std::string field = "\"";
    for (const char c : name) {
        if (c == '"') field += c;
        field += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? '?' : c;
    }
    return field + '"';
}

class ColumnSender {
  public:
    ColumnSender(std::vector<NumberArray> arrays, const TableOptions& options)
        : arrays_(std::move(arrays)), options_(options) {
        for (NumberArray& array : arrays_)
            if (array.rows == 1) std::swap(array.rows, array.columns);
    }

    Result<void> choose() {
        if (!options_.rate_hz) {
            AFFERENT_TRY(find_time());
        }
        for (const std::string& wanted : options_.columns) {
            const auto [found, column] = find(wanted);
            if (!found)
                return unfit("there is no dataset of numbers \"" + wanted + "\"; there are " + listed());
            if (rows_ == 0) rows_ = found->rows;
            if (found->rows != rows_)
                return unfit("\"" + found->name + "\" has " + std::to_string(found->rows) + " rows, and " +
                             (time_.empty() ? "another dataset" : "\"" + base_name(time_) + "\"") + " has " +
                             std::to_string(rows_));
            AFFERENT_TRY(take(*found, column));
        }
        if (options_.columns.empty())
            for (const NumberArray& array : arrays_) {
                if (rows_ == 0) rows_ = array.rows;
                if (array.name == time_ || array.rows != rows_) continue;
                AFFERENT_TRY(take(array));
            }
        if (columns_.size() == (time_.empty() ? 0U : 1U))
            return unfit("there is no dataset of numbers that is as long as time; there are " + listed());
        return success();
    }

    void send(const SendPiece& send) {
        const ColumnTextHead head{.rows = rows_};
        send(std::as_bytes(std::span(&head, 1)));
        std::string text = "sep=\t\n";
        for (std::size_t i = 0; i < columns_.size(); ++i) text += (i == 0 ? "" : "\t") + columns_[i].name;
        text += '\n';
        const std::uint64_t at_once = std::clamp<std::uint64_t>(numbers_at_once / width_, 1, rows_);
        for (std::uint64_t first = 0; first < rows_; first += at_once) {
            const std::uint64_t count = std::min(at_once, rows_ - first);
            for (Source& source : sources_) {
                source.values.resize(count * source.array->columns);
                if (const auto read = source.array->read(first, source.values); !read) {
                    text += why_no_more + read.error().text;
                    send(std::as_bytes(std::span(text)));
                    return;
                }
            }
            for (std::uint64_t row = 0; row < count; ++row) append_row(text, row);
            send(std::as_bytes(std::span(text)));
            text.clear();
        }
    }

  private:
    struct Source {
        const NumberArray* array;
        std::vector<double> values;  // of the rows that are sent next
    };
    struct SentColumn {
        std::string name;
        std::size_t source;
        std::uint64_t column;
    };

    void append_row(std::string& text, std::uint64_t row) const {
        std::array<char, 32> digits;
        for (std::size_t i = 0; i < columns_.size(); ++i) {
            const SentColumn& column = columns_[i];
            const Source& source = sources_[column.source];
            const double value = source.values[row * source.array->columns + column.column];
            const auto written = std::to_chars(digits.data(), digits.data() + digits.size(), value);
            if (i != 0) text += '\t';
            text.append(digits.data(), written.ptr);
        }
        text += '\n';
    }

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
        if (const auto* refusal = std::get_if<std::string>(&found))
            return unfit(*refusal + (arrays_.empty() ? "" : "; the datasets of numbers are " + listed()));
        const TimeColumn& position = std::get<TimeColumn>(found);
        const NumberArray& time = *single[position.position];
        if (position.date_position)
            return unfit("\"" + single[*position.date_position]->name + "\" and \"" + time.name +
                         "\" may both be time: say which by time_column (--time-column)");
        time_ = time.name;
        rows_ = time.rows;
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
        if (array.rows == 0 || array.columns == 0 || columns_.size() + array.columns > most_columns)
            return unfit("\"" + array.name + "\" is empty, or there are more than " +
                         std::to_string(most_columns) + " columns");
        auto source = std::ranges::find(sources_, &array, &Source::array);
        if (source == sources_.end()) {
            source = sources_.insert(sources_.end(), {&array, {}});
            width_ += array.columns;
        }
        const auto index = static_cast<std::size_t>(source - sources_.begin());
        const std::string name = base_name(array.name);
        for (std::uint64_t column = 0; column < array.columns; ++column)
            if (only == 0 || column + 1 == only)
                columns_.push_back(
                    {quoted(array.columns == 1 && !name.empty() ? name : numbered(name, column + 1)), index,
                     column});
        return success();
    }

    std::vector<NumberArray> arrays_;
    const TableOptions& options_;
    std::string time_;  // the dataset's name; empty: none is
    std::uint64_t rows_ = 0;
    std::uint64_t width_ = 0;  // of all sources
    std::vector<Source> sources_;
    std::vector<SentColumn> columns_;
};

}  // namespace

Result<void> send_columns(std::vector<NumberArray> arrays, const TableOptions& options,
                          const SendPiece& send) {
    ColumnSender sender(std::move(arrays), options);
    AFFERENT_TRY(sender.choose());
    sender.send(send);
    return success();
}

std::string asked_group(const TableOptions& options) {
    return folder_of(options.columns.empty() ? options.time_column : options.columns.front());
}

Result<std::string> group_of_table(const std::string& asked, const std::vector<DatasetGroup>& groups) {
    constexpr std::size_t most = 8;
    const auto is_asked = [&](const DatasetGroup& group) { return group.path == asked; };
    if (groups.empty() || std::ranges::any_of(groups, is_asked)) return asked;
    if (groups.size() == 1 && asked.empty()) return groups.front().path;
    std::string list;
    for (std::size_t i = 0; i < std::min(groups.size(), most); ++i) {
        list += (i == 0 ? "" : "; ") + groups[i].path;
        for (std::size_t k = 0; k < std::min(groups[i].names.size(), most); ++k)
            list += (k == 0 ? " (" : ", ") + groups[i].names[k];
        list += groups[i].names.size() > most ? ", …)" : ")";
    }
    return unfit((asked.empty() ? std::string("the file's root") : "\"" + asked + "\"") +
                 " has no datasets of numbers, and these groups have: " + list +
                 (groups.size() > most ? "; …" : "") + ". Name the columns with their group (--columns " +
                 groups.front().path + "NAME), or its time (--time-column " + groups.front().path + "NAME)");
}

TableOptions options_of_column_text(TableOptions options) {
    options.columns.clear();
    options.time_column = base_name(options.time_column);
    options.has_header = true;
    return options;
}

}  // namespace afferent
