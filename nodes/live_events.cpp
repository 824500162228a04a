#include "afferent/nodes/live_events.hpp"

#include <algorithm>

namespace afferent {
namespace {

// The most significant byte first.
void append(std::vector<std::byte>& bytes, std::uint32_t number) {
    for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::byte>(number >> shift));
}

std::uint32_t microseconds(TimePoint time) {
    return static_cast<std::uint32_t>((time - scene_start) / std::chrono::microseconds(1));
}

}  // namespace

Result<LiveEvents> LiveEvents::open(const Scene& scene, const Described& given, FullPipe) {
    AFFERENT_TRY(sender, given.path.empty()
                             ? DatagramSender::to_udp(given.host, static_cast<std::uint16_t>(given.port))
                             : DatagramSender::to_unix(scene.resolve(given.path).string()));
    LiveEvents opened(std::move(sender));
    opened.datagram_.reserve(4 + 8 * most_events);
    return opened;
}

void LiveEvents::observe(const TimeSpan&, std::span<const Event> events) {
    while (!events.empty()) {
        const auto some = events.first(std::min(events.size(), most_events));
        events = events.subspan(some.size());
        datagram_.clear();
        append(datagram_, number_++);
        for (const Event& event : some) {
            append(datagram_, event.address);
            append(datagram_, microseconds(event.time));
        }
        if (!sender_.send(datagram_)) lost_ += some.size();
    }
}

}  // namespace afferent
