#include "afferent/nodes/event_file.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <span>
#include <utility>

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

// The afferents of the scene that a recording holds; none where that scene is not this one's.
Population population_in(const std::string& file, const RecordedEvents& recorded,
                         std::vector<std::string>& remarks) {
    try {
        Population population = population_of(make_plan(Scene::from_text(recorded.scene, file)));
        const auto is_same = [](const Population::Patch& a, const Population::Patch& b) {
            return a.name == b.name && a.afferents == b.afferents;
        };
        if (std::ranges::equal(population.patches, recorded.set.population.patches, is_same))
            return population;
        remarks.push_back(file +
                          ": its scene has other patches: what is known of its afferents is their patch");
    } catch (const SceneError& error) {
        remarks.emplace_back(error.what());
    }
    return recorded.set.population;
}

// What a table of events does not tell, where there is one that does.
Result<void> add_afferents(const std::string& file, EventSet& set) {
    const std::filesystem::path beside = afferents_beside(file);
    std::error_code ignored;
    if (!std::filesystem::exists(beside, ignored)) return success();
    AFFERENT_TRY(table, read_afferents(beside));
    set.population = std::move(table.population);
    set.resolution = table.resolution;
    if (const Result<void> fits = check(set); !fits)
        return Error{Error::Kind::malformed, beside.string() + ": does not belong to " + file +
                                                 ", which is read together with it: " + fits.error().text +
                                                 ". Remove the one that is out of date"};
    return success();
}

Result<EventFile> read_recording(const std::string& file) {
    std::vector<std::string> remarks;
    AFFERENT_TRY(recorded, read_recorded_events(file, [&](const PacketCounts& session) {
                     if (session.gaps > 0)
                         remarks.push_back(file + ": " + std::to_string(session.gaps) + " gaps, " +
                                           std::to_string(session.lost_events) + " events lost");
                 }));
    if (recorded.sessions > 1)
        remarks.push_back(file + ": the events of " + std::to_string(recorded.sessions) +
                          " sessions, by time");
    if (!recorded.closed) remarks.push_back(file + ": was not closed, and may end early");
    recorded.set.population = population_in(file, recorded, remarks);
    return EventFile{std::move(recorded.set), std::move(remarks)};
}

}  // namespace

Result<EventFile> read_event_file(const std::filesystem::path& path) {
    const std::string file = path.string();
    if (file.ends_with(".afferent")) return read_recording(file);
    if (hdf5_format_of(file)) {
        AFFERENT_TRY(set, Hdf5Process(sibling_program("afferent-hdf5")).read(file));
        return EventFile{std::move(set), {}};
    }
    AFFERENT_TRY(format, format_of(file));
    AFFERENT_TRY(in, open_input(file));
    std::string text;
    std::array<char, 1 << 16> piece;
    while (const std::size_t size = std::fread(piece.data(), 1, piece.size(), in.get()))
        text.append(piece.data(), size);
    if (std::ferror(in.get()) != 0) return Error{Error::Kind::unreachable, file + ": cannot be read"};
    Result<std::vector<Event>> events = read_events(std::as_bytes(std::span(text)), format);
    if (!events) return Error{events.error().kind, file + ": " + events.error().text};
    EventFile read{{.events = std::move(events).value(),
                    .population = {},
                    .resolution = format == EventFormat::csv ? Duration(1ns) : Duration(1us)},
                   {}};
    if (format == EventFormat::csv) {
        AFFERENT_TRY(add_afferents(file, read.set));
    }
    return read;
}

}  // namespace afferent
