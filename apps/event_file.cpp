#include "afferent/apps/event_file.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <array>
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
#include "afferent/io/files/input_file.hpp"
#include "afferent/io/files/recorded_events.hpp"
#include "afferent/io/files/sibling_program.hpp"
#include "afferent/scene/population.hpp"

namespace afferent {
namespace {

// Who the afferents are, by the scene that a recording holds; nothing where it is not this one's.
Population population_in(const std::string& file, const RecordedEvents& recorded) {
    try {
        Population population = population_of(make_plan(Scene::from_text(recorded.scene, file)));
        const auto is_same = [](const Population::Patch& a, const Population::Patch& b) {
            return a.name == b.name && a.afferents == b.afferents;
        };
        if (std::ranges::equal(population.patches, recorded.set.population.patches, is_same))
            return population;
        std::cerr << file << ": its scene has other patches: what is known of its afferents is their patch\n";
    } catch (const SceneError& error) {
        std::cerr << error.what() << '\n';
    }
    return recorded.set.population;
}

// What a table of events does not tell, where there is one that does.
void add_afferents(const std::string& file, EventSet& set) {
    const std::filesystem::path beside = afferents_beside(file);
    std::error_code ignored;
    if (!std::filesystem::exists(beside, ignored)) return;
    auto [population, resolution] = value_or_fail(read_afferents(beside));
    set.population = std::move(population);
    set.resolution = resolution;
    if (const Result<void> fits = check(set); !fits)
        throw Failure(beside.string() + ": does not belong to " + file +
                      ", which is read together with it: " + fits.error().text +
                      ". Remove the one that is out of date");
}

EventSet read_recording(const std::string& file) {
    RecordedEvents recorded = value_or_fail(read_recorded_events(file, [&](const PacketCounts& session) {
        if (session.gaps > 0)
            std::cerr << file << ": " << session.gaps << " gaps, " << session.lost_events << " events lost\n";
    }));
    if (recorded.sessions > 1)
        std::cerr << file << ": the events of " << recorded.sessions << " sessions, by time\n";
    if (!recorded.closed) std::cerr << file << ": was not closed, and may end early\n";
    recorded.set.population = population_in(file, recorded);
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

bool is_event_format(const std::string& file) { return hdf5_format_of(file) || format_of(file); }

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
    EventSet set{.events = std::move(events).value(),
                 .population = {},
                 .resolution = format == EventFormat::csv ? Duration(1ns) : Duration(1us)};
    if (format == EventFormat::csv) add_afferents(file, set);
    return set;
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
