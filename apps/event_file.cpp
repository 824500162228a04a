#include "afferent/apps/event_file.hpp"

#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <utility>

#include "afferent/apps/failure.hpp"
#include "afferent/io/files/afferent_table.hpp"
#include "afferent/io/files/event_files.hpp"
#include "afferent/io/files/hdf5_format.hpp"
#include "afferent/io/files/hdf5_process.hpp"
#include "afferent/io/files/sibling_program.hpp"
#include "afferent/nodes/event_file.hpp"

namespace afferent {
namespace {

// Events have no date. Their time zero is estimated by taking the file's date for that of the last event.
std::chrono::system_clock::time_point session_start(const std::string& file, std::span<const Event> events) {
    struct stat status {};
    const auto written = ::stat(file.c_str(), &status) == 0
                             ? std::chrono::system_clock::from_time_t(status.st_mtime)
                             : std::chrono::system_clock::now();
    return events.empty() ? written
                          : written - std::chrono::duration_cast<std::chrono::system_clock::duration>(
                                          events.back().time - scene_start);
}

Hdf5Process hdf5_process() { return Hdf5Process(sibling_program("afferent-hdf5")); }

}  // namespace

bool is_event_format(const std::string& file) { return hdf5_format_of(file) || format_of(file); }

void check_event_format(const std::string& file) {
    if (!hdf5_format_of(file)) (void)value_or_fail(format_of(file));
}

EventSet read_event_set(const std::string& file) {
    EventFile read = value_or_fail(read_event_file(file));
    for (const std::string& remark : read.remarks) std::cerr << remark << '\n';
    return std::move(read.set);
}

void write_event_file(const std::string& file, const EventSet& set, const std::string& source) {
    if (hdf5_format_of(file))
        return value_or_fail(hdf5_process().write(file, set, session_start(source, set.events),
                                                  std::chrono::system_clock::now()));
    const EventFormat format = value_or_fail(format_of(file));
    const std::vector<std::byte> bytes = value_or_fail(write_events(set.events, format));
    std::ofstream out(file, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) throw Failure(file + ": cannot be written");
    if (format != EventFormat::csv) return;
    // Removes the files about afferents that an earlier export of this name wrote, where this one has none.
    std::error_code ignored;
    if (set.population.afferents.empty()) {
        std::filesystem::remove(afferents_beside(file), ignored);
        return;
    }
    if (const auto error = write_afferents(afferents_beside(file), set.population, set.resolution))
        throw Failure(error->message());
}

}  // namespace afferent
