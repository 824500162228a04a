// afferent convert: events from one file format to another.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <optional>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/io/event_files.hpp"
#include "afferent/io/handshake.hpp"
#include "afferent/io/packet_receiver.hpp"
#include "afferent/io/recording.hpp"

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
            // What is refused here was refused when it came.
            if (const auto reception = receiver->receive(entry.link()))
                events.insert(events.end(), reception.value().events.begin(), reception.value().events.end());
        }
    }
    tell_losses();
    if (sessions > 1) std::cerr << file << ": the events of " << sessions << " sessions, by time\n";
    if (!recording.closed()) std::cerr << file << ": was not closed, and may end early\n";
    // A coprocessor that began anew began at an earlier time.
    std::sort(events.begin(), events.end());
    return events;
}

std::vector<Event> events_of(const std::string& file) {
    if (file.ends_with(".afferent")) return events_of_recording(file);
    const EventFormat format = value_or_fail(format_of(file));
    std::ifstream in(file, std::ios::binary);
    if (!in) throw Failure(file + ": cannot be read");
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    Result<std::vector<Event>> events = read_events(std::as_bytes(std::span(text)), format);
    if (!events) throw Failure(file + ": " + events.error().text);
    return std::move(events).value();
}

void convert(const Options& options) {
    const EventFormat format = value_or_fail(format_of(options.to));
    const std::vector<Event> events = events_of(options.from);
    const std::vector<std::byte> bytes = value_or_fail(write_events(events, format));
    std::ofstream out(options.to, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) throw Failure(options.to + ": cannot be written");
    std::cout << events.size() << " events\n";
}

}  // namespace

void add_convert_command(CLI::App& app) {
    const auto options = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand(
        "convert",
        "Convert events: from a recording (.afferent), .csv, .es or .aedat to one of the latter three");
    command->add_option("from", options->from)->required();
    command->add_option("to", options->to)->required();
    command->footer("Example:\n  afferent convert out/grasp/events.csv grasp.es");
    command->callback([options] { convert(*options); });
}

}  // namespace afferent
