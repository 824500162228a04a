#include "afferent/io/pictures/gnuplot_script.hpp"

#include <array>
#include <charconv>

namespace afferent {
namespace {

bool ends_a_line(char c) { return c == '\n' || c == '\r' || c == '\0'; }

}  // namespace

std::string gnuplot_number(double value) {
    std::array<char, 32> text;
    const auto end =
        std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 7).ptr;
    return {text.data(), end};
}

std::string gnuplot_text(std::string_view text) {
    // Between single quotes gnuplot expands nothing, and a quote is doubled; between double quotes it would
    // run what stands between backticks.
    std::string quoted = "'";
    for (const char c : text) {
        if (c == '\'') quoted += '\'';
        quoted += ends_a_line(c) ? ' ' : c;
    }
    return quoted + "'";
}

std::string gnuplot_data_text(std::string_view text) {
    // A column ends at the next quotation mark, which cannot be escaped.
    std::string quoted = "\"";
    for (const char c : text) {
        if (c == '"')
            quoted += '\'';
        else
            quoted += ends_a_line(c) ? ' ' : c;
    }
    return quoted + '"';
}

}  // namespace afferent
