// afferent convert: events from one file format to another.
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <optional>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/io/files/event_files.hpp"
#include "afferent/io/files/hdf5_files.hpp"
#include "afferent/io/files/recording.hpp"
#include "afferent/io/wire/handshake.hpp"
#include "afferent/io/wire/packet_receiver.hpp"

namespace afferent {
namespace {

struct Options {
    std::string from;
    std::string to;
};

std::vector<Event> events_of_recording(const std::string& file) {
    RecordingReader recording = value_or_fail(RecordingReader::open(file));
    std::optional<PacketReceiver> receiver;
    std::vector<Event> events;
    std::uint64_t sessions = 0;
    const auto tell_losses = [&] {
        if (receiver && receiver->counts().gaps > 0)
            std::cerr << file << ": " << receiver->counts().gaps << " gaps, "
                      << receiver->counts().lost_events << " events lost\n";
    };
    proto::Entry entry;
    while (value_or_fail(recording.next(entry))) {
        if (entry.link().has_hello()) {
            tell_losses();
            receiver.emplace(value_or_fail(layout_of(entry.link().hello())));
            ++sessions;
        } else if (entry.link().position() != 0) {
            if (!receiver) throw Failure(file + ": has packets before any hello");
            // A packet that is refused here was refused when it was received.
            if (const auto reception = receiver->receive(entry.link()))
                events.insert(events.end(), reception.value().events.begin(), reception.value().events.end());
        }
    }
    tell_losses();
    if (sessions > 1) std::cerr << file << ": the events of " << sessions << " sessions, by time\n";
    if (!recording.closed()) std::cerr << file << ": was not closed, and may end early\n";
    // A coprocessor that was restarted begins again at an earlier time.
    std::sort(events.begin(), events.end());
    return events;
}

std::vector<Event> events_of(const std::string& file) {
    if (file.ends_with(".afferent")) return events_of_recording(file);
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

void write_file(const Options& options, std::span<const Event> events) {
    if (const auto format = hdf5_format_of(options.to)) {
        if (*format == Hdf5Format::sonata) return value_or_fail(write_sonata(options.to, events));
        return value_or_fail(write_nwb(options.to, events,
                                       {.description = "Address events converted by Afferent",
                                        .start = session_start(options.from, events),
                                        .created = std::chrono::system_clock::now()}));
    }
    const EventFormat format = value_or_fail(format_of(options.to));
    const std::vector<std::byte> bytes = value_or_fail(write_events(events, format));
    std::ofstream out(options.to, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) throw Failure(options.to + ": cannot be written");
}

void convert(const Options& options) {
    // Refuses an unknown ending before anything is read.
    if (!hdf5_format_of(options.to)) (void)value_or_fail(format_of(options.to));
    const std::vector<Event> events = events_of(options.from);
    write_file(options, events);
    std::cout << events.size() << " events\n";
}

}  // namespace

Command convert_command() {
    const auto options = std::make_shared<Options>();
    return {
        .name = "convert",
        .help =
            "Convert events between .csv, Event Stream (.es), AEDAT 2 (.aedat), SONATA (.sonata.h5) and NWB "
            "(.nwb), or from a recording (.afferent)",
        .footer =
            "Example:\n  afferent convert out/grasp/events.csv grasp.nwb\n"
            "  afferent convert grasp.afferent grasp.sonata.h5",
        .options =
            {
                positional("from", options->from, "The file to read").required(),
                positional("to", options->to, "The file to write; its ending says in which format")
                    .required(),
            },
        .run = [options] { convert(*options); },
    };
}

}  // namespace afferent
