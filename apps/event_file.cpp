#include "afferent/apps/event_file.hpp"

#include <sys/stat.h>

#include <array>
#include <chrono>
#include <fstream>
#include <iostream>
#include <utility>

#include "afferent/apps/failure.hpp"
#include "afferent/apps/sibling_program.hpp"
#include "afferent/io/files/event_files.hpp"
#include "afferent/io/files/hdf5_format.hpp"
#include "afferent/io/files/hdf5_process.hpp"
#include "afferent/io/files/input_file.hpp"
#include "afferent/io/files/recorded_events.hpp"

namespace afferent {
namespace {

EventSet read_recording(const std::string& file) {
    RecordedEvents recorded = value_or_fail(read_recorded_events(file, [&](const PacketCounts& session) {
        if (session.gaps > 0)
            std::cerr << file << ": " << session.gaps << " gaps, " << session.lost_events << " events lost\n";
    }));
    if (recorded.sessions > 1)
        std::cerr << file << ": the events of " << recorded.sessions << " sessions, by time\n";
    if (!recorded.closed) std::cerr << file << ": was not closed, and may end early\n";
    return std::move(recorded.set);
}

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

void check_event_format(const std::string& file) {
    if (!hdf5_format_of(file)) (void)value_or_fail(format_of(file));
}

EventSet read_event_file(const std::string& file) {
    if (file.ends_with(".afferent")) return read_recording(file);
    if (hdf5_format_of(file)) return value_or_fail(hdf5_process().read(file));
    const EventFormat format = value_or_fail(format_of(file));
    const InputFile in = value_or_fail(open_input(file));
    std::string text;
    std::array<char, 1 << 16> piece;
    while (const std::size_t size = std::fread(piece.data(), 1, piece.size(), in.get()))
        text.append(piece.data(), size);
    if (std::ferror(in.get()) != 0) throw Failure(file + ": cannot be read");
    Result<std::vector<Event>> events = read_events(std::as_bytes(std::span(text)), format);
    if (!events) throw Failure(file + ": " + events.error().text);
    return {.events = std::move(events).value(),
            .patches = {},
            .resolution = format == EventFormat::csv ? Duration(1ns) : Duration(1us)};
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
}

}  // namespace afferent
