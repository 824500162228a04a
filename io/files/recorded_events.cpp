#include "afferent/io/files/recorded_events.hpp"

#include <algorithm>
#include <optional>

#include "afferent/io/files/recording.hpp"
#include "afferent/io/wire/handshake.hpp"

namespace afferent {

Result<RecordedEvents> read_recorded_events(const std::filesystem::path& file,
                                            const std::function<void(const PacketCounts&)>& session_ended) {
    auto opened = RecordingReader::open(file);
    if (!opened) return opened.error();
    RecordingReader& recording = opened.value();
    RecordedEvents recorded;
    recorded.scene = recording.head().scene();
    std::vector<Event>& events = recorded.set.events;
    std::optional<PacketReceiver> receiver;
    proto::Entry entry;
    for (;;) {
        const Result<bool> more = recording.next(entry);
        if (!more) return more.error();
        if (!more.value()) break;
        if (entry.link().has_hello()) {
            if (receiver) session_ended(receiver->counts());
            const Result<PacketLayout> layout = layout_of(entry.link().hello());
            if (!layout) return layout.error();
            receiver.emplace(layout.value());
            if (recorded.sessions++ == 0) {
                recorded.set.resolution = layout.value().tick;
                for (const proto::PatchAddresses& patch : entry.link().hello().patch())
                    recorded.set.population.patches.push_back({patch.name(), patch.count()});
            }
        } else if (is_packet(entry.link())) {
            if (!receiver)
                return Error{Error::Kind::malformed, file.string() + ": has packets before any hello"};
            // A packet that is refused here was refused when it was received, too.
            if (const auto reception = receiver->receive(entry.link()))
                events.insert(events.end(), reception.value().events.begin(), reception.value().events.end());
        }
    }
    if (receiver) session_ended(receiver->counts());
    recorded.closed = recording.closed();
    // A restarted coprocessor begins again at an earlier time.
    std::sort(events.begin(), events.end());
    // The patches are those of the first session; the events of a later one may not fit them.
    if (!check(recorded.set)) recorded.set.population = {};
    return recorded;
}

}  // namespace afferent
