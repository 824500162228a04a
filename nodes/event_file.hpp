// Reads a file of events in any of the formats that Afferent knows, by the ending of its name.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "afferent/io/files/event_set.hpp"
#include "afferent/runtime/result.hpp"

namespace afferent {

struct EventFile {
    EventSet set;
    std::vector<std::string> remarks;  // what is incomplete, for a person
};

// The events with what the file tells of their afferents and resolution; a recording by its scene, a table of
// events by the table of afferents beside it. The program afferent-hdf5 reads HDF5.
Result<EventFile> read_event_file(const std::filesystem::path& file);

}  // namespace afferent
