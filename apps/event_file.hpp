// A file of events in any of the formats that the program knows, by the ending of its name.
#pragma once

#include <string>

#include "afferent/io/files/event_set.hpp"

namespace afferent {

// Throws Failure if write_event_file() knows no such ending.
void check_event_format(const std::string& file);

// The events with the patches and the resolution that the file states. What a recording lacks is reported on
// standard error. Throws Failure.
EventSet read_event_file(const std::string& file);

// `source` is the file that the events come from: its age tells when they happened. Throws Failure.
void write_event_file(const std::string& file, const EventSet& set, const std::string& source);

}  // namespace afferent
