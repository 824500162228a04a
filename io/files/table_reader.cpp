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

constexpr std::string_view time_column = "time_s";
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
std::optional<std::string> parse(std::string_view field, Number& number) {
    if (field.empty()) return "the field is empty";
    const char* const end = field.data() + field.size();
    const auto [stop, failure] = std::from_chars(field.data(), end, number);
    if (failure == std::errc::invalid_argument || stop != end) return in_quotes(field) + " is not a number";
    if (failure != std::errc()) return in_quotes(field) + " is beyond the range of numbers";
    if (!std::isfinite(number)) return in_quotes(field) + " is not finite";
    return std::nullopt;
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

TableReader::TableReader(std::string name, std::vector<std::string> wanted)
    : name_(std::move(name)), wanted_(std::move(wanted)), parser_(new csv_parser) {
    csv_init(parser_.get(), CSV_STRICT | CSV_STRICT_FINI);
}

std::optional<TableError> TableReader::feed(std::string_view bytes, const OnRow& on_row) {
    if (error_) return error_;
    if (Refusal refusal = take(bytes, on_row)) error_ = error(std::move(*refusal));
    return error_;
}

std::optional<TableError> TableReader::finish() {
    if (error_) return error_;
    if (!begun_.empty())
        error_ = error("the last line is cut off: it has no newline");
    else if (line_ == 1)
        error_ = TableError{name_, 0, "the table is empty"};
    else if (rows_ == 0)
        error_ = TableError{name_, 0, "the table has a header and no rows"};
    return error_;
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
                   std::to_string(static_cast<unsigned char>(*control));
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
    if (Refusal refusal = split(line)) return refusal;
    return line_ == 1 ? read_header() : read_row(on_row);
}

TableReader::Refusal TableReader::split(std::string_view line) {
    if (line.find_first_not_of(" \t") == std::string_view::npos) return "the line is blank";
    text_.clear();
    text_.reserve(line.size());
    fields_.clear();
    fields_.reserve(1 + static_cast<std::size_t>(std::ranges::count(line, ',')));
    Fields out{text_, fields_};
    if (csv_parse(parser_.get(), line.data(), line.size(), add_field, end_line, &out) != line.size() ||
        csv_fini(parser_.get(), add_field, end_line, &out) != 0) {
        if (csv_error(parser_.get()) != CSV_EPARSE) throw std::bad_alloc();
        return "a quotation mark is out of place";
    }
    return std::nullopt;
}

TableReader::Refusal TableReader::read_header() {
    // Columns are looked up in a map, because a body has 230,000 afferents, and a table may have a column for
    // each.
    std::unordered_map<std::string_view, std::size_t> positions;
    positions.reserve(fields_.size());
    for (std::size_t i = 0; i < fields_.size(); ++i)
        if (!positions.emplace(fields_[i], i).second) return "two columns are named " + in_quotes(fields_[i]);

    const auto missing = [this](std::string_view name) {
        return "there is no column " + in_quotes(name) + "; the columns are " + listed(fields_);
    };
    fields_in_header_ = fields_.size();
    const auto time = positions.find(time_column);
    if (time == positions.end()) return missing(time_column);
    time_position_ = time->second;
    if (wanted_.empty()) {
        for (const std::string_view name : fields_)
            if (name != time_column) wanted_.emplace_back(name);
        if (wanted_.empty()) return "there is no column but \"time_s\"";
    }
    for (const std::string& name : wanted_) {
        const auto found = positions.find(name);
        if (found == positions.end()) return missing(name);
        positions_.push_back(found->second);
    }
    columns_ = std::move(wanted_);
    values_.resize(columns_.size());
    return std::nullopt;
}

TableReader::Refusal TableReader::read_row(const OnRow& on_row) {
    if (fields_.size() != fields_in_header_)
        return "the row has " + std::to_string(fields_.size()) + " fields, the header " +
               std::to_string(fields_in_header_);
    if (Refusal refusal = read_time(fields_[time_position_])) return column_text(time_column, *refusal);
    for (std::size_t i = 0; i < values_.size(); ++i)
        if (Refusal refusal = parse(fields_[positions_[i]], values_[i]))
            return column_text(columns_[i], *refusal);
    ++rows_;
    on_row({line_, time_, values_});
    return std::nullopt;
}

TableReader::Refusal TableReader::read_time(std::string_view field) {
    // The 64-bit mantissa of long double keeps the nanoseconds of some years; double loses them after eleven
    // days.
    long double seconds = 0;
    if (Refusal refusal = parse(field, seconds)) return refusal;
    constexpr long double longest_s = 292.0L * 365.25L * 86400.0L;
    if (seconds < 0) return "a table begins at 0 s or later, not at " + std::string(field);
    if (seconds > longest_s) return std::string(field) + " s is beyond 292 years";
    const TimePoint time = scene_start + Duration(std::llround(seconds * 1e9L));
    if (rows_ > 0 && time <= time_)
        return std::string(field) + (time < time_
                                         ? " s is before the row above: time runs backwards"
                                         : " s is the time of the row above too: no sample lasts 0 s");
    time_ = time;
    return std::nullopt;
}

}  // namespace afferent
