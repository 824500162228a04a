// Packets of any content, one after the other: time only goes forward, and nothing lies outside of what it
// should.
#include <algorithm>

#include "afferent/io/packet_receiver.hpp"
#include "fuzz.hpp"
#include "layouts.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace afferent;
    FuzzInput input(data, size);
    const PacketLayout layout = fuzz_layout(input.byte());
    PacketReceiver receiver(layout);
    std::uint64_t events = 0;
    TimePoint gap_end = scene_start;
    while (!input.empty()) {
        const auto body = input.bytes(input.byte());
        proto::Envelope packet;
        if (!packet.ParseFromArray(body.data(), static_cast<int>(body.size()))) continue;
        const TimePoint before = receiver.end();
        const Result<Reception> received = receiver.receive(packet);
        must(receiver.end() >= before);
        if (!received) {
            must(receiver.end() == before);
            continue;
        }
        const Reception& reception = received.value();
        must(reception.known.begin < reception.known.end && reception.known.end == receiver.end());
        must(std::is_sorted(reception.events.begin(), reception.events.end()));
        for (const Event& event : reception.events) {
            must(event.address < layout.addresses);
            must(event.time >= reception.known.end - layout.span && event.time < reception.known.end);
        }
        events += reception.events.size();
        if (reception.gap) {
            must(reception.gap->begin >= gap_end && reception.gap->begin < reception.gap->end);
            gap_end = reception.gap->end;
        }
    }
    must(receiver.counts().events == events);
    return 0;
}
