// A file of events in any of the formats that the program knows, by the ending of its name.
#pragma once

#include <string>

#include "afferent/io/files/event_set.hpp"

namespace afferent {

// Whether write_event_file() knows the ending of its name.
bool is_event_format(const std::string& file);
// Throws Failure where it does not.
void check_event_format(const std::string& file);

// The events with what the file tells of their afferents and resolution; a recording by its scene, a table of
// events by the table of afferents beside it. What a recording lacks is reported on standard error. Throws
// Failure.
EventSet read_event_set(const std::string& file);

// `source` is the file that the events come from: its age tells when they happened. What CSV and SONATA tell
// of afferents goes into files beside it. Throws Failure.
void write_event_file(const std::string& file, const EventSet& set, const std::string& source);

}  // namespace afferent
