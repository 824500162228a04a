#include "afferent/io/files/plain_table.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <system_error>

#include "afferent/io/files/input_file.hpp"

namespace afferent {
namespace {

constexpr std::size_t largest_table = std::size_t{16} << 20U;

std::vector<std::string_view> fields_of(std::string_view line) {
    std::vector<std::string_view> fields;
    for (;;) {
        const std::size_t comma = line.find(',');
        fields.push_back(line.substr(0, comma));
        if (comma == std::string_view::npos) return fields;
        line.remove_prefix(comma + 1);
    }
}

// Cuts off the first line, without its end.
std::string_view take_line(std::string_view& text) {
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
}

}  // namespace

std::variant<std::vector<double>, TableError> read_plain_table(const std::filesystem::path& file,
                                                               const std::vector<std::string>& wanted) {
    std::size_t line_number = 0;
    const auto error = [&](std::string text) {
        return TableError{file.string(), line_number, std::move(text)};
    };
    std::error_code code;
    const bool regular = std::filesystem::is_regular_file(file, code);
    if (!regular && std::filesystem::exists(file, code)) return error("is no regular file");
    const auto in = open_input(file);
    // The message begins with the file's name, as a TableError's does.
    if (!in) return error(in.error().text.substr(file.string().size() + 2));
    std::string bytes(largest_table + 1, '\0');
    bytes.resize(std::fread(bytes.data(), 1, bytes.size(), in.value().get()));
    if (bytes.size() > largest_table)
        return error("has more than " + std::to_string(largest_table) + " bytes");

    std::string_view text = bytes;
    line_number = 1;
    const auto names = fields_of(take_line(text));
    std::vector<std::size_t> positions;
    for (const std::string& name : wanted) {
        const auto found = std::find(names.begin(), names.end(), name);
        if (found == names.end()) return error("has no column \"" + name + "\"");
        positions.push_back(static_cast<std::size_t>(found - names.begin()));
    }
    std::vector<double> values;
    while (!text.empty()) {
        ++line_number;
        const auto fields = fields_of(take_line(text));
        if (fields.size() != names.size())
            return error("has " + std::to_string(fields.size()) + " fields, the first line " +
                         std::to_string(names.size()));
        for (const std::size_t position : positions) {
            const std::string_view field = fields[position];
            double value = 0;
            const auto [end, failed] = std::from_chars(field.data(), field.data() + field.size(), value);
            if (failed != std::errc() || end != field.data() + field.size() || !std::isfinite(value))
                return error("\"" + std::string(field) + "\" is no number");
            values.push_back(value);
        }
    }
    if (values.empty()) return error("has no rows");
    return values;
}

}  // namespace afferent
