#include "afferent/apps/event_file.hpp"

#include <sys/stat.h>

#include <chrono>
#include <fstream>
#include <iostream>
#include <iterator>
#include <utility>

#include "afferent/apps/failure.hpp"
#include "afferent/io/files/event_files.hpp"
#include "afferent/io/files/hdf5_files.hpp"
#include "afferent/io/files/recorded_events.hpp"

namespace afferent {
namespace {

std::vector<Event> read_recording(const std::string& file) {
    RecordedEvents recorded = value_or_fail(read_recorded_events(file, [&](const PacketCounts& session) {
        if (session.gaps > 0)
            std::cerr << file << ": " << session.gaps << " gaps, " << session.lost_events << " events lost\n";
    }));
    if (recorded.sessions > 1)
        std::cerr << file << ": the events of " << recorded.sessions << " sessions, by time\n";
    if (!recorded.closed) std::cerr << file << ": was not closed, and may end early\n";
    return std::move(recorded.events);
}

// Events have no date. Time zero is estimated: the last event is taken to be as old as its file.
std::chrono::system_clock::time_point session_start(const std::string& file, std::span<const Event> events) {
    struct stat status {};
    const auto written = ::stat(file.c_str(), &status) == 0
                             ? std::chrono::system_clock::from_time_t(status.st_mtime)
                             : std::chrono::system_clock::now();
    return events.empty() ? written
                          : written - std::chrono::duration_cast<std::chrono::system_clock::duration>(
                                          events.back().time - scene_start);
}

}  // namespace

void check_event_format(const std::string& file) {
    if (!hdf5_format_of(file)) (void)value_or_fail(format_of(file));
}

std::vector<Event> read_event_file(const std::string& file) {
    if (file.ends_with(".afferent")) return read_recording(file);
    if (const auto format = hdf5_format_of(file)) {
        auto events = *format == Hdf5Format::sonata ? read_sonata(file) : read_nwb(file);
        if (!events) throw Failure(file + ": " + events.error().text);
        return std::move(events).value();
    }
    const EventFormat format = value_or_fail(format_of(file));
    std::ifstream in(file, std::ios::binary);
    if (!in) throw Failure(file + ": cannot be read");
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    Result<std::vector<Event>> events = read_events(std::as_bytes(std::span(text)), format);
    if (!events) throw Failure(file + ": " + events.error().text);
    return std::move(events).value();
}

void write_event_file(const std::string& file, std::span<const Event> events, const std::string& source) {
    if (const auto format = hdf5_format_of(file)) {
        if (*format == Hdf5Format::sonata) return value_or_fail(write_sonata(file, events));
        return value_or_fail(write_nwb(file, events,
                                       {.description = "Address events converted by Afferent",
                                        .start = session_start(source, events),
                                        .created = std::chrono::system_clock::now()}));
    }
    const EventFormat format = value_or_fail(format_of(file));
    const std::vector<std::byte> bytes = value_or_fail(write_events(events, format));
    std::ofstream out(file, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) throw Failure(file + ": cannot be written");
}

}  // namespace afferent
