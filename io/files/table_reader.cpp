#include "afferent/io/files/table_reader.hpp"

#include <csv.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <new>
#include <unordered_map>
#include <utility>

#include "afferent/io/files/column_unit.hpp"
#include "afferent/io/files/foreign_format.hpp"

namespace afferent {
namespace {

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

// No text has these; a table has no need of them either. A file in another format is known by them.
bool is_control(char c) { return (static_cast<unsigned char>(c) < 0x20 && c != '\t') || c == 0x7F; }

// A piece of the table as it may stand in a message.
std::string in_quotes(std::string_view field) {
    constexpr std::size_t enough = 40;
    return '"' + std::string(field.substr(0, enough)) + (field.size() > enough ? "…\"" : "\"");
}

std::string listed(std::span<const std::string> names) {
    std::string list;
    for (const std::string& name : names.first(std::min<std::size_t>(names.size(), 12)))
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

bool begins_like_number(std::string_view field) {
    return !field.empty() && std::string_view("0123456789+-.").find(field.front()) != std::string_view::npos;
}

bool begins_with_letter(std::string_view field) {
    const auto first = static_cast<unsigned char>(field.front());
    return first >= 0x80 || ((first | 0x20U) >= 'a' && (first | 0x20U) <= 'z');
}

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
    : name_(std::move(name)),
      options_(std::move(options)),
      parser_(new csv_parser),
      completer_(options_.missing) {
    csv_init(parser_.get(), CSV_STRICT | CSV_STRICT_FINI);
    format_.missing.rule = options_.missing;
}

std::optional<TableError> TableReader::feed(std::string_view bytes, const OnRow& on_row) {
    if (error_) return error_;
    if (Refusal refusal = take(bytes, on_row)) {
        error_ = error(std::move(*refusal));
        if (auto foreign = foreign_format(start_); foreign && rows_ == 0)
            error_ = TableError{name_, 0, std::move(*foreign)};
    }
    return error_;
}

std::optional<TableError> TableReader::finish(const OnRow& on_row) {
    if (error_) return error_;
    if (start_.size() == 1)
        if (Refusal refusal = take_bytes(start_, on_row)) return error_ = error(std::move(*refusal));
    if (!undecided_lines_.empty()) {
        decide_columns(true);
        if (Refusal refusal = read_undecided(on_row)) return error_ = error(std::move(*refusal));
    }
    if (!begun_.empty() && rows_ == 0)
        error_ = error("the last line is cut off: it has no newline");
    else if (blank_line_ != 0 && rows_ == 0)
        error_ = TableError{name_, blank_line_, "the line is blank"};
    else if (line_ == 1)
        error_ = TableError{name_, 0, "the table is empty"};
    else if (rows_ == 0 && no_header_ && !header_)
        error_ = TableError{name_, no_header_->line, no_header_->refusal};
    else if (rows_ == 0)
        error_ = TableError{name_, 0, "the table has a header and no rows"};
    else if (Refusal refusal = finish_rows(on_row))
        error_ = error(std::move(*refusal));
    if (!begun_.empty()) format_.left_out_line = line_;
    if (!error_ && handed_over_ == 0)
        error_ =
            TableError{name_, 0,
                       format_.missing.rows == rows_ ? "a value is missing in every row"
                                                     : "all rows are before begin_s, where the scene begins"};
    return error_;
}

TableReader::Refusal TableReader::finish_rows(const OnRow& on_row) {
    if (first_) {
        const std::size_t end = std::exchange(line_, first_->line);
        if (Refusal refusal = clock_->settle()) return column_text(format_.time_column, *refusal);
        if (Refusal refusal = hand_over_first(clock_->time(), on_row)) return refusal;
        line_ = end;
    }
    return completer_.finish([&](const TableRow& row) { deliver(row, on_row); });
}

TableFormat TableReader::format() const {
    TableFormat format = format_;
    if (clock_) clock_->fill_in(format);
    return format;
}

TableReader::Refusal TableReader::take(std::string_view bytes, const OnRow& on_row) {
    constexpr std::size_t enough = 8;
    if (start_.size() < enough) {
        const std::size_t before = start_.size();
        start_ += bytes.substr(0, enough - before);
        // UTF-16 is recognised by the first two bytes together.
        if (start_.size() < 2) return std::nullopt;
        if (before < 2) {
            const std::string_view two = std::string_view(start_).substr(0, 2);
            format_.utf16 = begins_in_utf16(two);
            if (format_.utf16) utf16_.emplace(two);
            if (before == 1)
                if (Refusal refusal = take_bytes(two.substr(0, 1), on_row)) return refusal;
        }
    }
    return take_bytes(bytes, on_row);
}

TableReader::Refusal TableReader::take_bytes(std::string_view bytes, const OnRow& on_row) {
    if (!utf16_) return take_text(bytes, on_row);
    const auto text = utf16_->decode(bytes);
    return text ? take_text(*text, on_row) : "the line is no text in UTF-16, as which the table begins";
}

TableReader::Refusal TableReader::take_text(std::string_view bytes, const OnRow& on_row) {
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
    if (fields_in_header_ == 0) {
        blank_line_ = 0;
        return read_head(line, on_row);
    }
    if (blank_line_ != 0) {
        line_ = blank_line_;
        return "the line is blank";
    }
    return read_fields(line, on_row);
}

TableReader::Refusal TableReader::read_fields(std::string_view line, const OnRow& on_row) {
    if (Refusal refusal = split(line)) return refusal;
    if (undecided_.empty()) return read_row(on_row);
    undecided_lines_.push_back({line_, std::string(line)});
    undecided_bytes_ += line.size();
    const bool at_last = undecided_lines_.size() == most_undecided_rows || undecided_bytes_ > longest_line;
    return decide_columns(at_last) ? read_undecided(on_row) : std::nullopt;
}

TableReader::Refusal TableReader::read_undecided(const OnRow& on_row) {
    const std::size_t end = line_;
    for (const Line& line : std::exchange(undecided_lines_, {})) {
        line_ = line.number;
        if (Refusal refusal = split(line.text)) return refusal;
        if (Refusal refusal = read_row(on_row)) return refusal;
    }
    line_ = end;
    return std::nullopt;
}

// A column holds text if its first field that is not empty begins with a letter, or if all are empty. One
// whose name has a unit never does: what stands there instead of a number is a fault to be told.
bool TableReader::decide_columns(bool at_last) {
    ignored_.resize(columns_.size());
    std::erase_if(undecided_, [&](std::size_t column) {
        if (positions_[column] >= fields_.size()) return true;
        const std::string_view field = fields_[positions_[column]];
        if (field.empty() && !at_last) return false;
        ignored_[column] = field.empty() || (begins_with_letter(field) && !stands_for_nothing(field) &&
                                             named_unit(columns_[column]).unit.empty());
        return true;
    });
    if (undecided_.empty()) leave_out_ignored();
    return undecided_.empty();
}

void TableReader::leave_out_ignored() {
    const auto left = static_cast<std::size_t>(std::ranges::count(ignored_, false));
    if (left == 0 || left == columns_.size()) return;
    std::vector<std::string> columns;
    std::vector<std::size_t> positions;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
        if (ignored_[i]) {
            format_.ignored_columns.push_back(std::move(columns_[i]));
            continue;
        }
        columns.push_back(std::move(columns_[i]));
        positions.push_back(positions_[i]);
    }
    columns_ = std::move(columns);
    positions_ = std::move(positions);
    values_.resize(columns_.size());
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
        return !parse_number<double>(number_, field, number) || parse_time(field);
    });
}

void TableReader::use_separator(char separator) {
    format_.separator = separator;
    // A line with a quotation mark out of place has left the parser in the middle.
    parser_.reset(new csv_parser);
    csv_init(parser_.get(), CSV_STRICT | CSV_STRICT_FINI);
    csv_set_delim(parser_.get(), static_cast<unsigned char>(separator));
}

TableReader::Refusal TableReader::split_head(std::string_view line) {
    if (!has_separator_) use_separator(separator_of(line));
    if (Refusal refusal = split(line)) return refusal;
    if (has_separator_ || format_.separator != ',' || line.find(' ') == std::string_view::npos ||
        is_row_of_numbers())
        return std::nullopt;
    // Decimal commas between spaces.
    use_separator(' ');
    if (Refusal refusal = split(line)) return refusal;
    if (fields_.size() > 1 && is_row_of_numbers()) return std::nullopt;
    use_separator(',');
    return split(line);
}

TableReader::Refusal TableReader::read_head(std::string_view line, const OnRow& on_row) {
    constexpr std::string_view separator_line = "sep=";  // as spreadsheets write and read it
    if (!has_separator_ && !header_ && line.size() == 5 && line.starts_with(separator_line)) {
        use_separator(line.back());
        has_separator_ = true;
        return std::nullopt;
    }
    const std::optional<Header> above = header_;
    if (above) {
        if (Refusal refusal = split(line)) return refusal;
        if (const auto found = units()) {
            format_.units_line = line_;
            return settle_header(*found);
        }
        const char separator = format_.separator;
        if (!is_below_header()) {
            header_.reset();
            if (Refusal refusal = split_head(line)) return refusal;
            if (!is_row_of_numbers() && !propose_header(line_)) {
                format_.has_preamble = true;
                return std::nullopt;
            }
            if (above->has_values) {
                if (Refusal refusal = no_header_yet("the line is above a header")) return refusal;
            } else {
                header_ = above;
                use_separator(separator);
            }
        }
        if (header_) {
            if (Refusal refusal = settle_header()) return refusal;
            return read_fields(line, on_row);
        }
    }
    if (Refusal refusal = split_head(line)) return refusal;
    if (options_.has_header || !is_row_of_numbers()) {
        if (Refusal refusal = propose_header(line_)) return no_header_yet(std::move(*refusal));
        return std::nullopt;
    }
    if (no_header_ && no_header_->fields == fields_.size()) {
        line_ = no_header_->line;
        return no_header_->refusal;
    }
    if (Refusal refusal = name_columns()) return refusal;
    return read_fields(line, on_row);
}

// What is no header says so with its line, once it is clear that there is no other.
TableReader::Refusal TableReader::no_header_yet(std::string refusal) {
    format_.has_preamble = true;
    if (!no_header_ || fields_.size() >= no_header_->fields)
        no_header_ = NoHeader{line_, fields_.size(), std::move(refusal)};
    if (++head_lines_ < most_head_lines) return std::nullopt;
    line_ = no_header_->line;
    return no_header_->refusal;
}

bool TableReader::is_below_header() const {
    if (!header_->time) return fields_.size() == header_->names.size();
    const std::size_t time = header_->time->position;
    return time < fields_.size() && begins_like_number(fields_[time]);
}

std::optional<std::vector<std::string>> TableReader::units() const {
    if (fields_.size() != header_->names.size()) return std::nullopt;
    std::vector<std::string> units;
    bool known = true;
    bool any = false;
    bool has_time = false;
    for (const std::string_view field : fields_) {
        if (begins_like_number(field)) return std::nullopt;
        const std::size_t column = units.size();
        units.emplace_back(unit_alone(field));
        // As a column's name ends in it.
        const std::string unit = named_unit("x [" + units.back() + "]").unit;
        any = any || !unit.empty();
        known = known && (unit.empty() || is_known_unit(unit));
        has_time = has_time || (header_->time && column == header_->time->position && time_unit_called(unit));
    }
    return has_time || (known && any) ? std::optional(std::move(units)) : std::nullopt;
}

TableReader::Refusal TableReader::propose_header(std::size_t line) {
    Header header{.line = line, .names = {fields_.begin(), fields_.end()}, .time = {}, .has_values = false};
    header.has_values = std::ranges::any_of(fields_, begins_like_number);
    if (!options_.rate_hz) {
        const auto found = find_time_column(header.names, options_);
        if (const auto* refusal = std::get_if<std::string>(&found)) return *refusal;
        header.time = std::get<TimeColumn>(found);
    }
    header_ = std::move(header);
    return std::nullopt;
}

// By a comment above it that has as many words, or by numbers from 1.
TableReader::Refusal TableReader::name_columns() {
    const std::size_t columns = fields_.size();
    const std::string comment = std::move(comment_);
    const char separator = format_.separator;
    use_separator(separator_of(comment));
    const bool named =
        !is_blank(comment) && !split(comment) && fields_.size() == columns && !is_row_of_numbers();
    use_separator(separator);
    std::vector<std::string> numbers;
    if (!named) {
        for (std::size_t i = 1; i <= columns; ++i) numbers.push_back(std::to_string(i));
        fields_.assign(numbers.begin(), numbers.end());
    }
    if (Refusal refusal = propose_header(named ? line_ - 1 : line_)) return refusal;
    if (Refusal refusal = settle_header()) return refusal;
    if (!named) format_.header_line = 0;
    return std::nullopt;
}

TableReader::Refusal TableReader::settle_header(const std::vector<std::string>& units) {
    // Where the header is refused, nothing more is read.
    const std::size_t line = std::exchange(line_, header_->line);
    fields_in_header_ = header_->names.size();
    format_.header_line = header_->line;
    std::vector<std::string> names = header_->names;
    for (std::size_t i = 0; i < units.size(); ++i)
        if (!units[i].empty() && !names[i].empty() && named_unit(names[i]).unit.empty())
            names[i] += " [" + units[i] + "]";
    if (const auto& time = header_->time) {
        time_position_ = time->position;
        date_position_ = time->date_position;
        TimeUnit unit = time->unit;
        if (unit == TimeUnit::found)
            unit = time_unit_called(named_unit(names[*time_position_]).unit).value_or(unit);
        format_.time_column = names[*time_position_];
        if (date_position_) format_.date_column = names[*date_position_];
        clock_.emplace(format_.time_column, unit, options_);
        clock_->fill_in(format_);
    }
    if (Refusal refusal = find_wanted_columns(names)) return refusal;
    header_.reset();
    line_ = line;
    return std::nullopt;
}

// A column of a table with a line of units has either name, with its unit and without.
TableReader::Refusal TableReader::find_wanted_columns(const std::vector<std::string>& names) {
    // Columns are looked up in a map, because a body has 230,000 afferents, and a table may have a column for
    // each.
    std::unordered_map<std::string_view, std::size_t> positions;
    positions.reserve(names.size());
    for (std::size_t i = 0; i < names.size(); ++i)
        if (!positions.emplace(names[i], i).second && !names[i].empty())
            return "two columns are named " + in_quotes(names[i]);
    for (std::size_t i = 0; i < names.size(); ++i) positions.emplace(header_->names[i], i);
    if (options_.columns.empty()) {
        for (std::size_t i = 0; i < names.size(); ++i)
            if (i != time_position_ && i != date_position_ && !names[i].empty()) {
                undecided_.push_back(positions_.size());
                positions_.push_back(i);
            }
        if (positions_.empty()) return "there is no column but " + in_quotes(format_.time_column);
    }
    for (const std::string& name : options_.columns) {
        const auto found = positions.find(name);
        if (found == positions.end())
            return "there is no column " + in_quotes(name) + "; the columns are " + listed(names);
        positions_.push_back(found->second);
    }
    for (const std::size_t position : positions_) columns_.push_back(names[position]);
    values_.resize(columns_.size());
    return std::nullopt;
}

TableReader::Refusal TableReader::read_row(const OnRow& on_row) {
    if (fields_.size() != fields_in_header_)
        return "the row has " + std::to_string(fields_.size()) + " fields, the header " +
               std::to_string(fields_in_header_);
    ++rows_;
    const bool was_waiting = first_.has_value();
    if (time_position_) {
        if (options_.missing != Missing::refuse && stands_for_nothing(fields_[*time_position_])) {
            format_.missing.count(line_, format_.time_column);
            ++format_.missing.rows;
            return std::nullopt;
        }
        if (Refusal refusal = read_time()) return column_text(format_.time_column, *refusal);
    } else {
        time_ = sample_time(rows_ - 1, *options_.rate_hz);
    }
    if (was_waiting)
        if (Refusal refusal = hand_over_first(clock_->time_before(), on_row)) return refusal;
    const std::size_t missing = format_.missing.values;
    for (std::size_t i = 0; i < values_.size(); ++i)
        if (Refusal refusal = parse_value(i)) return column_text(columns_[i], *refusal);
    if (format_.missing.values != missing) ++format_.missing.rows;
    if (!clock_ || clock_->is_certain()) return hand_over(line_, time_, values_, on_row);
    first_ = First{line_, values_};
    return std::nullopt;
}

TableReader::Refusal TableReader::parse_value(std::size_t column) {
    const std::string_view field = fields_[positions_[column]];
    if (!stands_for_nothing(field)) return parse(field, values_[column]);
    if (options_.missing == Missing::refuse)
        return (field.empty() ? "the field is empty" : in_quotes(field) + " is no number") +
               "; missing (--missing skip or interpolate) says what to do about it";
    format_.missing.count(line_, columns_[column]);
    values_[column] = std::numeric_limits<double>::quiet_NaN();
    return std::nullopt;
}

// A row before the time at which the table begins is skipped.
TableReader::Refusal TableReader::hand_over(std::size_t line, TimePoint time, std::span<const double> values,
                                            const OnRow& on_row) {
    if (time < scene_start) return std::nullopt;
    return completer_.take({line, time, values}, [&](const TableRow& row) { deliver(row, on_row); });
}

TableReader::Refusal TableReader::hand_over_first(TimePoint time, const OnRow& on_row) {
    const First first = *std::exchange(first_, {});
    return hand_over(first.line, time, first.values, on_row);
}

void TableReader::deliver(const TableRow& row, const OnRow& on_row) {
    ++handed_over_;
    on_row(row);
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

TableReader::Refusal TableReader::read_time() {
    std::string_view field = fields_[*time_position_];
    if (date_position_) {
        date_and_time_.assign(fields_[*date_position_]).append(" ").append(field);
        field = date_and_time_;
    }
    const TimeUnit unit = clock_->unit();
    if (unit == TimeUnit::date || (unit == TimeUnit::found && !first_ && rows_ == 1))
        if (const auto written = parse_time(field, clock_->date_order())) {
            if (Refusal refusal = clock_->take(*written, in_quotes(field))) return refusal;
            time_ = clock_->time();
            return std::nullopt;
        }
    if (unit == TimeUnit::date || date_position_)
        return in_quotes(field) +
               " is not a date such as 2026-11-22T14:03:07.125Z, nor a time of day such as 14:03:07.125";
    // The 64-bit mantissa of long double keeps the nanoseconds of some years; double loses them after eleven
    // days.
    long double time = 0;
    if (Refusal refusal = parse(field, time)) return refusal;
    if (Refusal refusal = clock_->take(time, field)) return refusal;
    time_ = clock_->time();
    return std::nullopt;
}

}  // namespace afferent
