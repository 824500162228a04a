#include "afferent/io/files/table_reader.hpp"

#include <csv.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <new>
#include <unordered_map>
#include <utility>

namespace afferent {
namespace {

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

// No text has these; a table has no need of them either. What is left (a file in another format, a table in
// UTF-16) is found out at its first bytes.
bool is_control(char c) { return (static_cast<unsigned char>(c) < 0x20 && c != '\t') || c == 0x7F; }

// A piece of the table as it may stand in a message.
std::string in_quotes(std::string_view field) {
    constexpr std::size_t enough = 40;
    return '"' + std::string(field.substr(0, enough)) + (field.size() > enough ? "…\"" : "\"");
}

std::string listed(std::span<const std::string_view> names) {
    std::string list;
    for (const std::string_view name : names.first(std::min<std::size_t>(names.size(), 12)))
        list += (list.empty() ? "" : ", ") + in_quotes(name);
    return names.size() > 12 ? list + ", …" : list;
}

std::string column_text(std::string_view column, const std::string& text) {
    return "column " + in_quotes(column) + ": " + text;
}

// Reads the whole field, in no locale. Returns what is wrong with it.
template <class Number>
std::optional<std::string> parse_number(std::string_view field, std::string_view shown, Number& number) {
    if (field.empty()) return "the field is empty";
    const char* const end = field.data() + field.size();
    const auto [stop, failure] = std::from_chars(field.data(), end, number);
    if (failure == std::errc::invalid_argument || stop != end) return in_quotes(shown) + " is not a number";
    if (failure != std::errc()) return in_quotes(shown) + " is beyond the range of numbers";
    if (!std::isfinite(number)) return in_quotes(shown) + " is not finite";
    return std::nullopt;
}

bool is_blank(std::string_view line) { return line.find_first_not_of(" \t") == std::string_view::npos; }

struct Fields {
    std::string& text;
    std::vector<std::string_view>& fields;
};

// Both are called from C and must not throw, so split() has reserved the memory that they need.
void add_field(void* bytes, std::size_t size, void* context) noexcept {
    auto& [text, fields] = *static_cast<Fields*>(context);
    const std::size_t begin = text.size();
    text.append(static_cast<const char*>(bytes), size);
    fields.emplace_back(text.data() + begin, size);
}
void end_line(int, void*) noexcept {}

}  // namespace

void TableReader::FreeParser::operator()(csv_parser* parser) const noexcept {
    csv_free(parser);
    delete parser;
}

TableReader::TableReader(std::string name, TableOptions options)
    : name_(std::move(name)), options_(std::move(options)), parser_(new csv_parser) {
    csv_init(parser_.get(), CSV_STRICT | CSV_STRICT_FINI);
}

std::optional<TableError> TableReader::feed(std::string_view bytes, const OnRow& on_row) {
    if (error_) return error_;
    if (Refusal refusal = take(bytes, on_row)) error_ = error(std::move(*refusal));
    return error_;
}

std::optional<TableError> TableReader::finish(const OnRow& on_row) {
    if (error_) return error_;
    if (!begun_.empty() && rows_ == 0)
        error_ = error("the last line is cut off: it has no newline");
    else if (blank_line_ != 0 && rows_ == 0)
        error_ = TableError{name_, blank_line_, "the line is blank"};
    else if (line_ == 1)
        error_ = TableError{name_, 0, "the table is empty"};
    else if (rows_ == 0)
        error_ = TableError{name_, 0, "the table has a header and no rows"};
    else if (first_) {
        if (Refusal refusal = clock_->settle())
            error_ = TableError{name_, first_->line, column_text(format_.time_column, *refusal)};
        else
            hand_over_first(clock_->time(), on_row);
    }
    if (!begun_.empty()) format_.left_out_line = line_;
    if (!error_ && handed_over_ == 0)
        error_ = TableError{name_, 0, "all rows are before begin_s, where the scene begins"};
    return error_;
}

TableFormat TableReader::format() const {
    TableFormat format = format_;
    if (clock_) clock_->fill_in(format);
    return format;
}

TableReader::Refusal TableReader::take(std::string_view bytes, const OnRow& on_row) {
    while (!bytes.empty()) {
        const std::size_t newline = bytes.find('\n');
        const std::string_view piece = bytes.substr(0, newline);
        if (begun_.size() + piece.size() > longest_line)
            return "the line is longer than " + std::to_string(longest_line) + " bytes";
        // A carriage return is allowed only before the newline; whether one follows is checked later.
        const auto control = std::ranges::find_if(piece, [](char c) { return is_control(c) && c != '\r'; });
        if (control != piece.end())
            return "this is not a table of text: it has a byte of value " +
                   std::to_string(static_cast<unsigned char>(*control)) +
                   (*control == '\x1f' ? "; what gzip has compressed is read from a file, or through zcat"
                                       : "");
        if (newline == std::string_view::npos) {
            begun_ += piece;
            return std::nullopt;
        }
        Refusal refusal;
        if (begun_.empty()) {
            refusal = read_line(piece, on_row);
        } else {
            begun_ += piece;
            refusal = read_line(begun_, on_row);
            begun_.clear();
        }
        if (refusal) return refusal;
        ++line_;
        bytes.remove_prefix(newline + 1);
    }
    return std::nullopt;
}

TableReader::Refusal TableReader::read_line(std::string_view line, const OnRow& on_row) {
    if (line_ == 1 && line.starts_with(byte_order_mark)) line.remove_prefix(byte_order_mark.size());
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.find('\r') != std::string_view::npos) return "a carriage return stands inside the line";
    if (is_comment(line)) return std::nullopt;
    if (is_blank(line)) {
        if (blank_line_ == 0) blank_line_ = line_;
        return std::nullopt;
    }
    if (blank_line_ != 0) {
        line_ = blank_line_;
        return "the line is blank";
    }
    if (fields_in_header_ == 0) return read_first_line(line, on_row);
    if (Refusal refusal = split(line)) return refusal;
    return read_row(on_row);
}

bool TableReader::is_comment(std::string_view line) {
    const std::size_t begin = line.find_first_not_of(" \t");
    if (begin == std::string_view::npos || (line[begin] != '#' && line[begin] != '%')) return false;
    if (fields_in_header_ == 0)
        comment_ = line.substr(std::min(line.find_first_not_of(" \t#%"), line.size()));
    return true;
}

TableReader::Refusal TableReader::split(std::string_view line) {
    text_.clear();
    text_.reserve(line.size());
    fields_.clear();
    if (format_.separator == ' ') {
        split_at_spaces(line);
        return std::nullopt;
    }
    fields_.reserve(1 + static_cast<std::size_t>(std::ranges::count(line, format_.separator)));
    Fields out{text_, fields_};
    if (csv_parse(parser_.get(), line.data(), line.size(), add_field, end_line, &out) != line.size() ||
        csv_fini(parser_.get(), add_field, end_line, &out) != 0) {
        if (csv_error(parser_.get()) != CSV_EPARSE) throw std::bad_alloc();
        return "a quotation mark is out of place";
    }
    return std::nullopt;
}

// In a header, "Force [N]" is one column.
void TableReader::split_at_spaces(std::string_view line) {
    text_ = line;
    const std::string_view text = text_;
    for (std::size_t begin = text.find_first_not_of(" \t"); begin < text.size();) {
        const std::size_t end = std::min(text.find_first_of(" \t", begin), text.size());
        const bool is_unit = text[begin] == '[' || text[begin] == '(';
        if (is_unit && !fields_.empty()) {
            const auto from = static_cast<std::size_t>(fields_.back().data() - text.data());
            fields_.back() = text.substr(from, end - from);
        } else {
            fields_.push_back(text.substr(begin, end - begin));
        }
        begin = text.find_first_not_of(" \t", end);
    }
}

bool TableReader::is_row_of_numbers() {
    const char mark = format_.separator == ',' ? '.' : ',';
    return !fields_.empty() && std::ranges::all_of(fields_, [&](std::string_view field) {
        number_ = field;
        std::ranges::replace(number_, mark, '.');
        double number = 0;
        return !parse_number<double>(number_, field, number) || parse_date(field);
    });
}

TableReader::Refusal TableReader::read_first_line(std::string_view line, const OnRow& on_row) {
    constexpr std::string_view separator_line = "sep=";  // as spreadsheets write and read it
    if (!has_separator_ && line.size() == 5 && line.starts_with(separator_line)) {
        format_.separator = line.back();
        has_separator_ = true;
        csv_set_delim(parser_.get(), static_cast<unsigned char>(line.back()));
        return std::nullopt;
    }
    const auto use = [this](char separator) {
        format_.separator = separator;
        csv_set_delim(parser_.get(), static_cast<unsigned char>(separator));
    };
    if (!has_separator_) use(separator_of(line));
    if (Refusal refusal = split(line)) return refusal;
    bool numbers = is_row_of_numbers();
    // Decimal commas between spaces.
    if (!numbers && !has_separator_ && format_.separator == ',' && line.find(' ') != std::string_view::npos) {
        use(' ');
        if (Refusal refusal = split(line)) return refusal;
        numbers = fields_.size() > 1 && is_row_of_numbers();
        if (!numbers) {
            use(',');
            if (Refusal refusal = split(line)) return refusal;
        }
    }
    if (!numbers) {
        format_.header_line = line_;
        return read_header();
    }
    if (Refusal refusal = name_columns()) return refusal;
    if (Refusal refusal = split(line)) return refusal;
    return read_row(on_row);
}

// By a comment above it that has as many words, or by numbers from 1.
TableReader::Refusal TableReader::name_columns() {
    const std::size_t columns = fields_.size();
    const std::string comment = std::move(comment_);
    const char separator = format_.separator;
    format_.separator = separator_of(comment);
    csv_set_delim(parser_.get(), static_cast<unsigned char>(format_.separator));
    const bool named =
        !is_blank(comment) && !split(comment) && fields_.size() == columns && !is_row_of_numbers();
    format_.separator = separator;
    // A comment with a quotation mark out of place has left the parser in the middle.
    parser_.reset(new csv_parser);
    csv_init(parser_.get(), CSV_STRICT | CSV_STRICT_FINI);
    csv_set_delim(parser_.get(), static_cast<unsigned char>(separator));
    if (named) {
        format_.header_line = line_ - 1;
        return read_header();
    }
    std::vector<std::string> numbers;
    for (std::size_t i = 1; i <= columns; ++i) numbers.push_back(std::to_string(i));
    fields_.assign(numbers.begin(), numbers.end());
    return read_header();
}

TableReader::Refusal TableReader::read_header() {
    // Columns are looked up in a map, because a body has 230,000 afferents, and a table may have a column for
    // each.
    std::unordered_map<std::string_view, std::size_t> positions;
    positions.reserve(fields_.size());
    for (std::size_t i = 0; i < fields_.size(); ++i)
        if (!positions.emplace(fields_[i], i).second && !fields_[i].empty())
            return "two columns are named " + in_quotes(fields_[i]);

    fields_in_header_ = fields_.size();
    const std::vector<std::string> names(fields_.begin(), fields_.end());
    if (!options_.rate_hz) {
        const auto found = find_time_column(names, options_);
        if (const auto* refusal = std::get_if<std::string>(&found)) return *refusal;
        const auto& time = std::get<TimeColumn>(found);
        time_position_ = time.position;
        clock_.emplace(names[time.position], time.unit, options_);
        clock_->fill_in(format_);
    }
    if (options_.columns.empty()) {
        for (std::size_t i = 0; i < names.size(); ++i)
            if (i != time_position_ && !names[i].empty()) options_.columns.push_back(names[i]);
        if (options_.columns.empty()) return "there is no column but " + in_quotes(format_.time_column);
    }
    for (const std::string& name : options_.columns) {
        const auto found = positions.find(name);
        if (found == positions.end())
            return "there is no column " + in_quotes(name) + "; the columns are " + listed(fields_);
        positions_.push_back(found->second);
    }
    columns_ = options_.columns;
    values_.resize(columns_.size());
    return std::nullopt;
}

TableReader::Refusal TableReader::read_row(const OnRow& on_row) {
    if (fields_.size() != fields_in_header_)
        return "the row has " + std::to_string(fields_.size()) + " fields, the header " +
               std::to_string(fields_in_header_);
    const bool was_waiting = first_.has_value();
    if (time_position_) {
        if (Refusal refusal = read_time(fields_[*time_position_]))
            return column_text(format_.time_column, *refusal);
    } else {
        time_ = sample_time(rows_, *options_.rate_hz);
    }
    if (was_waiting) hand_over_first(clock_->time_before(), on_row);
    for (std::size_t i = 0; i < values_.size(); ++i)
        if (Refusal refusal = parse(fields_[positions_[i]], values_[i]))
            return column_text(columns_[i], *refusal);
    ++rows_;
    if (clock_ && !clock_->is_certain())
        first_ = First{line_, values_};
    else
        hand_over(line_, time_, values_, on_row);
    return std::nullopt;
}

// A row before the time at which the table begins is skipped.
void TableReader::hand_over(std::size_t line, TimePoint time, std::span<const double> values,
                            const OnRow& on_row) {
    if (time < scene_start) return;
    ++handed_over_;
    on_row({line, time, values});
}

void TableReader::hand_over_first(TimePoint time, const OnRow& on_row) {
    hand_over(first_->line, time, first_->values, on_row);
    first_.reset();
}

// Where a comma separates columns it is no decimal mark. Elsewhere the first number with a mark decides, and
// there are no marks of thousands: "1,234" is less than two.
template <class Number>
TableReader::Refusal TableReader::parse(std::string_view field, Number& number) {
    const std::size_t mark = format_.separator == ',' ? field.find('.') : field.find_first_of(".,");
    if (mark == std::string_view::npos) return parse_number(field, field, number);
    if (format_.decimal_mark_line == 0) {
        format_.decimal_mark = field[mark];
        format_.decimal_mark_line = line_;
    }
    if (format_.separator == ',') return parse_number(field, field, number);
    const char other = format_.decimal_mark == ',' ? '.' : ',';
    if (field.find(other) != std::string_view::npos)
        return in_quotes(field) + " has a " + (other == ',' ? "comma" : "point") +
               ", and the decimal mark is a " + (other == ',' ? "point" : "comma") + " since line " +
               std::to_string(format_.decimal_mark_line) + "; thousands have no mark";
    if (format_.decimal_mark == '.') return parse_number(field, field, number);
    number_ = field;
    number_[mark] = '.';
    if (number_.find(',') != std::string::npos) return in_quotes(field) + " is not a number";
    return parse_number(std::string_view(number_), field, number);
}

TableReader::Refusal TableReader::read_time(std::string_view field) {
    const bool may_be_date = clock_->unit() == TimeUnit::date || clock_->unit() == TimeUnit::found;
    if (const auto date = may_be_date ? parse_date(field) : std::nullopt) {
        if (clock_->unit() == TimeUnit::found && rows_ == 0)
            clock_.emplace(format_.time_column, TimeUnit::date, options_);
        if (clock_->unit() == TimeUnit::date) {
            if (Refusal refusal = clock_->take(static_cast<long double>(*date), field)) return refusal;
            time_ = clock_->time();
            return std::nullopt;
        }
    }
    if (clock_->unit() == TimeUnit::date)
        return in_quotes(field) + " is not a date such as 2026-11-22T14:03:07.125Z";
    // The 64-bit mantissa of long double keeps the nanoseconds of some years; double loses them after eleven
    // days.
    long double time = 0;
    if (Refusal refusal = parse(field, time)) return refusal;
    if (Refusal refusal = clock_->take(time, field)) return refusal;
    time_ = clock_->time();
    return std::nullopt;
}

}  // namespace afferent
