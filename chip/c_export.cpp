#include "afferent/chip/c_export.hpp"

#include <algorithm>
#include <bit>
#include <iterator>
#include <sstream>

#include "afferent/io/wire/packetizer.hpp"

namespace afferent {
namespace {

// The smallest of C's types that holds so many bits.
std::uint32_t type_bits(std::uint32_t bits) { return bits <= 8 ? 8 : bits <= 16 ? 16 : bits <= 32 ? 32 : 64; }
std::string signed_type(std::uint32_t bits) { return "int" + std::to_string(type_bits(bits)) + "_t"; }
std::string unsigned_type(std::uint32_t bits) { return "uint" + std::to_string(type_bits(bits)) + "_t"; }

std::string group_rows(const ChipNeurons& neurons) {
    std::ostringstream rows;
    for (const ChipNeurons::Group& group : neurons.groups) {
        const FixedPointLif::Codes& c = group.neuron.codes();
        rows << "    {" << group.begin + group.count << ", " << c.one << ", " << c.v_decay << ", "
             << c.g_decay << ", " << c.conductance << ", " << c.threshold << ", " << c.reset << ", "
             << c.lowest << ", " << c.highest << ", " << c.g_jump << ", " << c.g_most << ", " << c.decay_bits
             << ", " << c.conductance_bits << ", " << c.refractory_ticks << "u, "
             << (c.rounding == Rounding::half_even) << "},\n";
    }
    return rows.str();
}

// Where neurons begin at different phases.
std::string start_table(const ChipNeurons& neurons, const std::string& type) {
    std::string table = "static const " + type + " start[AFFERENT_NEURONS] = {";
    for (Address i = 0; i < neurons.count(); ++i)
        table += (i % 16 == 0 ? "\n    " : " ") + std::to_string(neurons.start[i].u) + ",";
    return table + "\n};\n";
}

std::string piece_rows(const CountsEncoder& encoder) {
    std::ostringstream rows;
    for (const CountsCurve& curve : encoder.curves)
        for (const CountsCurve::Piece& piece : curve.pieces)
            rows << "    {" << piece.p << ", " << piece.q << ", " << piece.s << ", " << piece.r << ", "
                 << piece.offset << ", " << piece.begin << "u},\n";
    return rows.str();
}

std::string curve_rows(const CountsEncoder& encoder) {
    std::vector<std::size_t> first{0};  // piece of each curve
    for (const CountsCurve& curve : encoder.curves) first.push_back(first.back() + curve.pieces.size());
    std::ostringstream rows;
    for (std::size_t end = 1; end <= encoder.curve.size(); ++end) {
        const std::uint32_t curve = encoder.curve[end - 1];
        if (end < encoder.curve.size() && encoder.curve[end] == curve) continue;
        rows << "    {" << end << ", " << first[curve] << ", " << first[curve + 1] - 1 << ", "
             << encoder.curves[curve].highest_count << "u},\n";
    }
    return rows.str();
}

void add_files(std::vector<ExportedFile>& files, std::vector<ExportedFile> more) {
    std::ranges::move(more, std::back_inserter(files));
}

std::vector<ExportedFile> encoder_files(const CountsEncoder& encoder, std::uint32_t input_bits,
                                        const std::string& scene) {
    return filled_templates("c_encoder/", {{"scene", in_a_comment(scene)},
                                           {"offset_type", signed_type(std::max(input_bits, 32U))},
                                           {"pieces", piece_rows(encoder)},
                                           {"curves", curve_rows(encoder)}});
}

// Readings take a message of their own: tag and length, tick, first, and at most 24 bits a count.
std::uint64_t readings_bytes(const ChipNeurons& neurons) { return 64 + std::uint64_t{4} * neurons.count(); }

std::string numbers(const std::vector<std::byte>& bytes) {
    std::string text;
    for (const std::byte byte : bytes)
        text += (text.empty() ? "" : ", ") + std::to_string(std::to_integer<unsigned>(byte));
    return text;
}

std::vector<ExportedFile> wire_files(const ChipParts& parts, const ChipNeurons& neurons,
                                     const std::string& scene) {
    const PacketLayout& layout = *parts.wire;
    const std::uint64_t events = most_chip_events(layout, neurons);
    PacketLayout part = layout;
    part.max_events = static_cast<std::uint32_t>(std::min<std::uint64_t>(events, layout.max_events));
    Replacements values{
        {"scene", in_a_comment(scene)},
        {"hello", numbers(parts.hello)},
        {"span_us", std::to_string(layout.span / 1us)},
        {"heartbeat_us", std::to_string(layout.heartbeat_spans() * layout.span / 1us)},
        {"ticks_per_span", std::to_string(layout.span.count() / neurons.tick_ns)},
        {"gathered_spans", std::to_string(layout.gathered_spans)},
        {"heartbeat_spans", std::to_string(layout.heartbeat_spans())},
        {"span_codes", std::to_string(layout.span_codes())},
        {"wire_tick_ns", std::to_string(layout.tick.count())},
        {"events", std::to_string(events)},
        {"most_events", std::to_string(layout.max_events)},
        {"message_bytes",
         std::to_string(std::max<std::uint64_t>(most_packet_bytes(part), readings_bytes(neurons)))},
        {"code_type",
         unsigned_type(std::max(16U, static_cast<std::uint32_t>(std::bit_width(layout.codes() - 1))))},
        {"code_bytes", std::to_string(PayloadCodec(layout).code_bytes())}};
    const char* const payload =
        layout.encoding == Encoding::rice ? "c_payload/rice" : "c_payload/fixed_width";
    values.insert(values.begin(), {"payload", filled_templates(payload, values).front().text});
    return filled_templates("c_wire/", values);
}

}  // namespace

std::uint32_t exported_bytes_per_neuron(const ChipNeurons& neurons) {
    const ChipWidths widths = chip_widths(neurons);
    std::uint32_t bytes = 0;
    std::uint32_t aligned = 1;
    for (const std::uint32_t bits :
         {widths.input_bits, widths.u_bits, widths.g_bits, widths.refractory_bits}) {
        const std::uint32_t size = type_bits(bits) / 8;
        aligned = std::max(aligned, size);
        bytes = (bytes + size - 1) / size * size + size;
    }
    return (bytes + aligned - 1) / aligned * aligned;
}

std::vector<ExportedFile> export_c(const ChipNeurons& neurons, const ChipParts& parts,
                                   const std::string& scene) {
    const ChipWidths widths = chip_widths(neurons);
    const std::string u_type = signed_type(widths.u_bits);
    const bool at_rest = neurons.begins_at_rest();
    const Replacements values{{"scene", in_a_comment(scene)},
                              {"neurons", std::to_string(neurons.count())},
                              {"tick_ns", std::to_string(neurons.tick_ns)},
                              {"tick_us", std::to_string(neurons.tick_ns / 1000)},
                              {"input_bits", std::to_string(widths.input_bits)},
                              {"input_type", signed_type(widths.input_bits)},
                              {"u_type", u_type},
                              {"g_type", unsigned_type(widths.g_bits)},
                              {"refractory_type", unsigned_type(widths.refractory_bits)},
                              {"wide", signed_type(std::max(widths.product_bits, 32U))},
                              {"product_bits", std::to_string(widths.product_bits)},
                              {"bytes", std::to_string(exported_bytes_per_neuron(neurons))},
                              {"groups", group_rows(neurons)},
                              {"start", at_rest ? "" : start_table(neurons, u_type)},
                              {"start_u", at_rest ? "c->reset" : "start[i]"},
                              {"encoder", parts.encoder ? "1" : "0"},
                              {"wire", parts.wire ? "1" : "0"},
                              {"more_sources", std::string(parts.encoder ? " afferent_encoder.c" : "") +
                                                   (parts.wire ? " afferent_wire.c" : "")}};
    std::vector<ExportedFile> files = filled_templates("c/", values);
    if (parts.encoder) add_files(files, encoder_files(*parts.encoder, widths.input_bits, scene));
    if (parts.wire) add_files(files, wire_files(parts, neurons, scene));
    if (parts.encoder && parts.wire)
        add_files(files, filled_templates("c_twin/", {{"scene", in_a_comment(scene)}}));
    return files;
}

}  // namespace afferent
