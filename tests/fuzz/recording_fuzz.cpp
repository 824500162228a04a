// A file of any bytes, as a recording and in the formats of events: it is read to its end or refused with a
// message, with the same result entry by entry and by its marks, and events that were read are written and
// read back equal.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>

#include "afferent/io/files/event_files.hpp"
#include "afferent/nodes/replay.hpp"
#include "fuzz.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

// Enough for every input; a scene of any length may be claimed.
constexpr int most_steps = 2000;

const fs::path& write(std::span<const std::byte> bytes) {
    static const fs::path file =
        fs::temp_directory_path() / ("afferent-fuzz-" + std::to_string(getpid()) + ".afferent");
    std::FILE* out = std::fopen(file.c_str(), "wb");
    must(out != nullptr && std::fwrite(bytes.data(), 1, bytes.size(), out) == bytes.size());
    std::fclose(out);
    return file;
}

void read_entries(const fs::path& file, std::size_t size) {
    auto opened = RecordingReader::open(file);
    if (!opened) return must(!opened.error().text.empty());
    RecordingReader& reader = opened.value();
    proto::Entry entry;
    const auto marks = reader.marks();
    std::size_t entries = 0;
    std::size_t found = 0;
    for (;; ++entries) {
        must(entries <= size);
        const Result<bool> next = reader.next(entry);
        if (!next || !next.value()) break;
        if (entry.has_mark()) ++found;
    }
    if (!marks) return;
    must(reader.closed() || marks.value().size() == found);
    for (const RecordedMark& mark : marks.value())
        if (reader.go_to(mark)) must(reader.next(entry) && entry.has_mark());
}

void replay(const fs::path& file, TimePoint from) {
    TimePoint last = TimePoint::min();
    auto opened = Replay::open(file, {.step =
                                          [&](const ControllerStep& step) {
                                              must(step.time >= from && step.time > last);
                                              last = step.time;
                                          },
                                      .starting_over = [&] { last = TimePoint::min(); }});
    if (!opened) return must(!opened.error().text.empty());
    Replay& replay = *opened.value();
    // What is long before is not run through here.
    if (from > scene_start && !replay.begin_from(from)) return;
    for (int i = 0; i < most_steps; ++i) {
        const auto next = replay.next();
        if (!next || !next.value()) return;
        replay.step();
    }
}

void read_files(std::span<const std::byte> bytes) {
    for (const EventFormat format : {EventFormat::csv, EventFormat::event_stream, EventFormat::aedat2}) {
        const auto events = read_events(bytes, format);
        if (!events) {
            must(!events.error().text.empty());
            continue;
        }
        must(std::is_sorted(events.value().begin(), events.value().end()));
        // Silence is cheap to read in a stream, and not to write.
        const bool long_silence = format == EventFormat::event_stream && !events.value().empty() &&
                                  events.value().back().time > scene_start + 1min;
        if (long_silence) continue;
        const auto written = write_events(events.value(), format);
        if (!written && format == EventFormat::aedat2 && events.value().front().address >> 24 == '#')
            continue;
        must(written && read_events(written.value(), format).value() == events.value());
    }
}

}  // namespace
}  // namespace afferent

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace afferent;
    FuzzInput input(data, size);
    const std::uint8_t choice = input.byte();
    const auto bytes = input.rest();
    if (choice % 4 == 0) {
        read_files(bytes);
        return 0;
    }
    const fs::path& file = write(bytes);
    read_entries(file, bytes.size());
    replay(file, scene_start + (choice % 4 == 1 ? 0 : choice) * Duration(10ms));
    fs::remove(file);
    return 0;
}
