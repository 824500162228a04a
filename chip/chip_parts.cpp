#include "afferent/chip/chip_parts.hpp"

#include "afferent/io/wire/cobs.hpp"
#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/handshake.hpp"
#include "afferent/io/wire/message_types.hpp"
#include "afferent/scene/chip_fingerprint.hpp"
#include "afferent/scene/scene_error.hpp"

namespace afferent {
namespace {

// A few hundred kilobytes of them: more than firmware has room for.
constexpr std::uint64_t most_events = 65536;

std::string why_no_wire(const Plan& plan, const ChipNeurons& neurons) {
    if (!plan.packets) return "link: it carries no packets";
    if (plan.bus) return "link.bus: events reach the packets in an order that the bus decides";
    const PacketLayout& layout = *plan.packets;
    if (layout.encoding == Encoding::predicted) return "link.encoding: a chip writes RICE or FIXED_WIDTH";
    if (layout.span.count() % neurons.tick_ns != 0)
        return "link.packet_ms (or prompt_ms) must be a multiple of neuron.fixed_point.tick_us";
    if (most_chip_events(layout, neurons) > most_events)
        return "link.packet_ms: a packet may have more than " + std::to_string(most_events) + " events";
    return "";
}

std::vector<std::byte> hello(const Plan& plan, const ChipNeurons& neurons) {
    proto::Envelope message;
    proto::ChipHello& chip = *message.mutable_chip();
    chip.set_version(wire_version);
    chip.set_fingerprint(chip_fingerprint(plan).value());
    chip.set_addresses(neurons.count());
    chip.set_tick_ns(static_cast<std::uint64_t>(neurons.tick_ns));
    chip.set_span_ns(static_cast<std::uint64_t>(plan.packets->span.count()));
    FrameWriter writer;
    std::vector<std::byte> line;
    append_cobs(writer.datagram(message), line);
    return line;
}

}  // namespace

std::uint64_t most_chip_events(const PacketLayout& layout, const ChipNeurons& neurons) {
    return static_cast<std::uint64_t>(layout.span.count() / neurons.tick_ns) * layout.gathered_spans *
           neurons.count();
}

ChipParts chip_parts(const Plan& plan, const ChipNeurons& neurons) {
    ChipParts parts;
    try {
        parts.encoder = counts_encoder(plan);
    } catch (const SceneError& error) {
        parts.why_no_encoder = error.what();
    }
    parts.why_no_wire = why_no_wire(plan, neurons);
    if (!parts.why_no_wire.empty()) return parts;
    parts.wire = plan.packets;
    parts.hello = hello(plan, neurons);
    return parts;
}

}  // namespace afferent
