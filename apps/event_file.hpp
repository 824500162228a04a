// A file of events in any of the formats that the program knows, by the ending of its name.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "afferent/runtime/event.hpp"

namespace afferent {

// Throws Failure where write_event_file() knows no such ending.
void check_event_format(const std::string& file);

// Sorted by time and address. What a recording lacks is told on standard error. Throws Failure.
std::vector<Event> read_event_file(const std::string& file);

// `source` is the file that the events come from: its age tells when they happened. Throws Failure.
void write_event_file(const std::string& file, std::span<const Event> events, const std::string& source);

}  // namespace afferent
