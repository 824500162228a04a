// What a command tells of a run, for people and for programs.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace afferent {

// Keeps the order in which things were told.
using Summary = nlohmann::ordered_json;

// As JSON; what is no UTF-8 in it is replaced, and not an exception.
std::string json(const Summary& summary, int indent = -1);

// One line for each entry.
void print(const Summary& summary);
// To standard output, as JSON or for people.
void print(const Summary& summary, bool json);
// Throws Failure if the file cannot be written.
void write(const Summary& summary, const std::filesystem::path& file);

}  // namespace afferent
