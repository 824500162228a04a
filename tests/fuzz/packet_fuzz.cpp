// Packets of any content, one after the other: time only goes forward, spans and events lie within their
// limits, and what was said of a span is not taken back.
#include <algorithm>
#include <optional>

#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/proto/aer.pb.h"
#include "fuzz.hpp"
#include "layouts.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace afferent;
    FuzzInput input(data, size);
    const std::uint8_t choice = input.byte();
    const PacketLayout& layout = fuzz_layout(choice);
    PacketReceiver receiver = made_for_fuzz_layout<PacketReceiver>(choice);
    std::uint64_t events = 0;
    std::optional<Event> last;
    TimePoint known_begin = scene_start;
    TimePoint gap_end = scene_start;
    while (!input.empty()) {
        const auto body = input.bytes(input.byte());
        proto::Envelope packet;
        if (!packet.ParseFromArray(body.data(), static_cast<int>(body.size()))) continue;
        const TimePoint before = receiver.end();
        const Result<Reception> received = receiver.receive(packet);
        proto::Envelope answer;
        if (receiver.acknowledge(answer)) {
            const proto::Acknowledgement& acknowledgement = answer.acknowledgement();
            must(layout.acknowledged);
            const auto end = static_cast<std::uint32_t>(receiver.position() % position_modulus) + 1;
            must(acknowledgement.position() == 0 || acknowledgement.position() == end);
        }
        must(receiver.end() >= before);
        if (!received) {
            must(receiver.end() == before);
            continue;
        }
        const Reception& reception = received.value();
        const bool predicted = layout.encoding == Encoding::predicted;
        must(reception.known.end == receiver.end());
        if (!reception.measured()) {
            // Refers to what has not come.
            must(predicted && reception.events.empty());
            if (reception.gap) gap_end = reception.gap->end;
            continue;
        }
        must(std::is_sorted(reception.events.begin(), reception.events.end()));
        for (const Event& event : reception.events) {
            must(event.address < layout.addresses);
            must(event.time >= reception.known.begin && event.time < reception.known.end);
            must(predicted || event.time >= reception.known.end - layout.gathered_spans * layout.span);
        }
        events += reception.events.size();
        // A further part of the packet before, or behind it.
        must(reception.known.begin >= before ||
             (reception.known.begin == known_begin && reception.known.end == before));
        known_begin = reception.known.begin;
        if (!reception.events.empty()) {
            must(!last || !(reception.events.front() < *last));
            last = reception.events.back();
        }
        if (reception.gap) {
            must(reception.gap->begin >= gap_end && reception.gap->begin < reception.gap->end);
            gap_end = reception.gap->end;
        }
    }
    must(receiver.counts().events == events);
    return 0;
}
