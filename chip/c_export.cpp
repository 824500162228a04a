#include "afferent/chip/c_export.hpp"

#include <algorithm>
#include <sstream>

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

std::vector<ExportedFile> export_c(const ChipNeurons& neurons, const std::string& scene) {
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
                              {"start_u", at_rest ? "c->reset" : "start[i]"}};
    return filled_templates("c/", values);
}

}  // namespace afferent
