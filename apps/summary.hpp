// Summaries as text: JSON for programs, lines for people.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "afferent/runtime/summary.hpp"

namespace afferent {

// As JSON, on one line where indent < 0. Text that is not UTF-8 is replaced rather than refused.
std::string json(const Summary& summary, int indent = -1);
// Nothing if the text is not JSON. Values nested more deeply than a summary's become unknown.
std::optional<Summary> parse_summary(std::string_view json);

// Adds the entries of another.
void append(Summary& summary, const Summary& more);

// One line for each entry.
void print(const Summary& summary);
// As JSON or for people, with a line's end.
std::string text(const Summary& summary, bool json);
// To standard output, as JSON or for people.
void print(const Summary& summary, bool json);
// Throws Failure if the file cannot be written.
void write(const Summary& summary, const std::filesystem::path& file);

}  // namespace afferent
