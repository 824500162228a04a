// Events and acknowledgements of any content, as a hand may send them: the coprocessor goes on, remembers no
// more than it should, and its packets stay within their limits.
#include "afferent/io/wire/packetizer.hpp"
#include "afferent/proto/aer.pb.h"
#include "fuzz.hpp"
#include "layouts.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace afferent;
    FuzzInput input(data, size);
    const std::uint8_t choice = input.byte();
    const PacketLayout& layout = fuzz_layout(choice);
    if (layout.encoding != Encoding::predicted) return 0;
    Packetizer packetizer = made_for_fuzz_layout<Packetizer>(choice);
    std::vector<Event> events;
    TimePoint deadline = scene_start;
    while (!input.empty()) {
        const std::uint8_t next = input.byte();
        if (next % 2 == 0) {
            proto::Acknowledgement acknowledgement;
            const auto body = input.bytes(next / 2);
            if (!acknowledgement.ParseFromArray(body.data(), static_cast<int>(body.size()))) continue;
            const bool possible = packetizer.acknowledge(acknowledgement);
            must(layout.acknowledged || !possible);
            continue;
        }
        // So many events in the next span, and up to 63 spans without any after it.
        events.clear();
        for (int i = 0; i < next / 2 % 8; ++i)
            events.push_back({deadline + input.byte() % (layout.span / layout.tick) * layout.tick,
                              input.byte() % layout.addresses});
        std::sort(events.begin(), events.end());
        packetizer.push(events);
        deadline += (1 + next / 16) * layout.span;
        packetizer.close(deadline, [&](const proto::Envelope& packet) {
            must(packet.ByteSizeLong() <= most_packet_bytes(layout));
        });
    }
    return 0;
}
