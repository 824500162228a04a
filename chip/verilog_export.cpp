#include "afferent/chip/verilog_export.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <utility>

namespace afferent {
namespace {

std::string range(std::uint32_t bits) { return "[" + std::to_string(bits - 1) + ":0]"; }

std::uint32_t bits_of(std::int64_t highest) {
    return static_cast<std::uint32_t>(std::bit_width(static_cast<std::uint64_t>(highest)));
}

// A product with K is shifted by at least as many bits as g, which it is multiplied by, has: K is shifted the
// other way before.
std::uint32_t conductance_steps(const FixedPointLif::Codes& c) {
    return std::max(c.conductance_bits, bits_of(c.g_most));
}
std::int64_t shifted_conductance(const FixedPointLif::Codes& c) {
    return c.conductance << (conductance_steps(c) - c.conductance_bits);
}

std::uint32_t cycles(const FixedPointLif::Codes& c) { return 8 + 3 * c.decay_bits + conductance_steps(c); }

// Signed, so that no sum of two of what is added leaves it.
std::uint32_t width(const ChipNeurons& neurons) {
    const ChipWidths widths = chip_widths(neurons);
    std::uint32_t bits = std::max(widths.u_bits, widths.input_bits) + 1;  // of u - b
    for (const ChipNeurons::Group& group : neurons.groups) {
        const FixedPointLif::Codes& c = group.neuron.codes();
        bits = std::max({bits, bits_of(c.g_most + c.g_jump) + 1, bits_of(shifted_conductance(c)) + 1,
                         bits_of(c.one) + 1});
    }
    return bits + 1;
}

std::uint32_t multiplier_bits(const ChipNeurons& neurons) {
    std::uint32_t bits = 0;
    for (const ChipNeurons::Group& group : neurons.groups)
        bits = std::max({bits, group.neuron.codes().decay_bits, bits_of(group.neuron.codes().g_most)});
    return bits;
}

// A number of so many bits, signed.
std::string literal(std::int64_t value, std::uint32_t bits) {
    return (value < 0 ? "-" : "") + std::to_string(bits) + "'sd" + std::to_string(std::abs(value));
}

// A case for each group, the last one for all that is left.
std::string group_cases(const ChipNeurons& neurons) {
    const std::uint32_t bits = width(neurons);
    const auto text = [](std::uint64_t value) { return std::to_string(value); };
    std::string cases;
    for (std::size_t i = 0; i < neurons.groups.size(); ++i) {
        const ChipNeurons::Group& group = neurons.groups[i];
        const FixedPointLif::Codes& c = group.neuron.codes();
        const std::vector<std::pair<const char*, std::string>> constants{
            {"end_address", text(group.begin + group.count - 1)},
            {"one", literal(c.one, bits)},
            {"v_decay", text(static_cast<std::uint64_t>(c.v_decay))},
            {"g_decay", text(static_cast<std::uint64_t>(c.g_jump > 0 ? c.g_decay : 0))},
            {"conductance", literal(shifted_conductance(c), bits)},
            {"threshold", literal(c.threshold, bits)},
            {"reset_u", literal(c.reset, bits)},
            {"lowest", literal(c.lowest, bits)},
            {"highest", literal(c.highest, bits)},
            {"g_jump", literal(c.g_jump, bits)},
            {"g_most", literal(c.g_most, bits)},
            {"decay_bits", text(c.decay_bits)},
            {"conductance_bits", text(conductance_steps(c))},
            {"refractory_ticks", text(c.refractory_ticks)},
            {"even", text(c.rounding == Rounding::half_even)}};
        cases += "            " + (i + 1 < neurons.groups.size() ? text(i) : "default") + ": begin";
        for (const auto& [name, value] : constants) cases += std::string(" ") + name + " = " + value + ";";
        cases += " end\n";
    }
    return cases;
}

// Where neurons begin at different phases.
std::string start_function(const ChipNeurons& neurons, std::uint32_t address_bits) {
    const std::uint32_t bits = width(neurons);
    std::string function =
        "    function signed [W-1:0] start_of(input " + range(address_bits) + " who);\n        case (who)\n";
    for (Address i = 0; i < neurons.count(); ++i)
        function += "            " + (i + 1 < neurons.count() ? std::to_string(i) : "default") +
                    ": start_of = " + literal(neurons.start[i].u, bits) + ";\n";
    return function + "        endcase\n    endfunction\n";
}

}  // namespace

std::uint64_t exported_cycles_per_tick(const ChipNeurons& neurons) {
    std::uint64_t sum = 1;  // between ticks
    for (const ChipNeurons::Group& group : neurons.groups)
        sum += std::uint64_t{cycles(group.neuron.codes())} * group.count;
    return sum;
}

std::vector<ExportedFile> export_verilog(const ChipNeurons& neurons, const std::string& scene) {
    const ChipWidths widths = chip_widths(neurons);
    const std::uint32_t address_bits = std::max(bits_of(neurons.count() - 1), 1U);
    const std::uint32_t group_bits =
        std::max(bits_of(static_cast<std::int64_t>(neurons.groups.size()) - 1), 1U);
    const std::uint32_t refractory_bits = std::max(widths.refractory_bits, 1U);
    const std::uint32_t g_end = widths.u_bits + widths.g_bits;
    const bool at_rest = neurons.begins_at_rest();
    const auto text = [](std::uint64_t value) { return std::to_string(value); };
    const Replacements values{{"scene", in_a_comment(scene)},
                              {"neurons", text(neurons.count())},
                              {"tick_us", text(static_cast<std::uint64_t>(neurons.tick_ns / 1000))},
                              {"last", text(neurons.count() - 1)},
                              {"cycles", text(exported_cycles_per_tick(neurons))},
                              {"width", text(width(neurons))},
                              {"multiplier_bits", text(multiplier_bits(neurons))},
                              {"address_bits", text(address_bits)},
                              {"address_range", range(address_bits)},
                              {"address_top", text(address_bits - 1)},
                              {"address_padding", address_bits < 16 ? text(16 - address_bits) + "'d0, " : ""},
                              {"group_range", range(group_bits)},
                              {"input_range", range(widths.input_bits)},
                              {"input_top", text(widths.input_bits - 1)},
                              {"u_top", text(widths.u_bits - 1)},
                              {"g_bottom", text(widths.u_bits)},
                              {"g_top", text(g_end - 1)},
                              {"g_bits", text(widths.g_bits)},
                              {"g_width_top", text(widths.g_bits - 1)},
                              {"g_padding", text(64 - widths.g_bits)},
                              {"refractory_bottom", text(g_end)},
                              {"refractory_top", text(g_end + refractory_bits - 1)},
                              {"refractory_range", range(refractory_bits)},
                              {"refractory_bits", text(refractory_bits)},
                              {"refractory_padding", text(64 - refractory_bits)},
                              {"state_top", text(g_end + refractory_bits - 1)},
                              {"event_bits", text(16 + address_bits)},
                              {"groups", group_cases(neurons)},
                              {"start_function", at_rest ? "" : start_function(neurons, address_bits)},
                              {"start", at_rest ? "reset_u" : "start_of(address)"}};
    return filled_templates("verilog/", values);
}

}  // namespace afferent
