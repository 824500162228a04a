// afferent convert: events from one file format to another.
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/event_file.hpp"

namespace afferent {
namespace {

struct ConvertOptions {
    std::string from;
    std::string to;
};

void convert(const ConvertOptions& options) {
    // Refuses an unknown ending before anything is read.
    check_event_format(options.to);
    const std::vector<Event> events = read_event_file(options.from);
    write_event_file(options.to, events, options.from);
    std::cout << events.size() << " events\n";
}

}  // namespace

Command convert_command() {
    const auto options = std::make_shared<ConvertOptions>();
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
