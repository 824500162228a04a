// The exported Verilog: simulated against its vectors, changed, proved and synthesised.
#include "afferent/chip/verilog_export.hpp"

#include <gtest/gtest.h>

#include <regex>

#include "tests/chip/exported_chip.hpp"

namespace afferent {
namespace {

// So many ticks of each part as iverilog simulates in a second.
constexpr VectorLength short_enough{.busy = 300, .silent = 100, .read = 0};

ExportedChip exported_verilog(const ChipNeurons& neurons, const VectorLength& length = short_enough) {
    return {neurons, {}, export_verilog(neurons, "test"), length};
}

// Empty: equal to the vectors.
std::string simulated(ExportedChip& chip) { return chip.failure_of("make -s icarus TICKS=100000"); }

class SimulatedWidth : public testing::TestWithParam<const char*> {};

TEST_P(SimulatedWidth, IsEqualToTheEmulatorToTheBitAndDoesNotOverflow) {
    SKIP_WITHOUT("iverilog");
    SKIP_WITHOUT("yosys");
    for (const char* const rounding : {"HALF_EVEN", "TRUNCATION"})
        for (const char* const neuron : {"delta_g: 0.03 refractory_ms: 3", "delta_g: 0"}) {
            const std::string fixed_point = GetParam() + std::string(" rounding: ") + rounding;
            ExportedChip chip = exported_verilog(chip_of({fixed_point}, neuron));
            EXPECT_EQ(simulated(chip), "") << fixed_point;
            EXPECT_EQ(chip.failure_of("make -s proof"), "") << fixed_point;
        }
}

INSTANTIATE_TEST_SUITE_P(All, SimulatedWidth, testing::ValuesIn(widths_of_chips),
                         [](const auto& each) { return std::to_string(each.index); });

TEST(VerilogExport, HasNeuronsOfSeveralWidthsAndSaturates) {
    SKIP_WITHOUT("verilator");
    const ChipNeurons neurons = chip_of_several_widths();
    EXPECT_EQ(neurons.groups.size(), 3U);
    ExportedChip chip = exported_verilog(neurons, VectorLength::of_simulation(neurons));
    EXPECT_EQ(chip.failure_of("make -s verilator"), "");
}

// So that the proof says something: a width of one bit less is refused.
TEST(VerilogExport, IsNotProvedWhereASumOverflows) {
    SKIP_WITHOUT("yosys");
    ExportedChip chip = exported_verilog(chip_of({"tick_us: 1000"}));
    std::string& core = chip.file("afferent_chip.v");
    std::smatch width;
    ASSERT_TRUE(std::regex_search(core, width, std::regex("localparam W = ([0-9]+);")));
    core.replace(static_cast<std::size_t>(width.position(1)), static_cast<std::size_t>(width.length(1)),
                 std::to_string(std::stoi(width[1]) - 1));
    EXPECT_NE(chip.failure_of("make -s proof"), "");
}

// The clock is too slow for the ticks: the next is due while the neurons are still at work.
TEST(VerilogExport, SaysWhereATickComesTooSoon) {
    SKIP_WITHOUT("iverilog");
    ExportedChip chip = exported_verilog(chip_of({"tick_us: 1000"}));
    chip.make({"@(negedge clk) tick_valid = 0;", "repeat (3) @(negedge clk); tick_valid = 0;"},
              "afferent_test.v");
    EXPECT_NE(simulated(chip).find("tick 1: a tick came too soon"), std::string::npos) << chip.said();
}

TEST(VerilogExport, BeginsAtThePhasesOfTheScene) {
    SKIP_WITHOUT("iverilog");
    SKIP_WITHOUT("yosys");
    ChipNeurons neurons = chip_of({"tick_us: 1000"}, "delta_g: 0.03", 3);
    neurons.start[0] = neurons.groups[0].neuron.at_phase(0.9);
    neurons.start[2] = neurons.groups[0].neuron.at_phase(0.5);
    ExportedChip chip = exported_verilog(neurons);
    EXPECT_EQ(simulated(chip), "");
    EXPECT_EQ(chip.failure_of("make -s proof"), "");
    chip.make({"start_u = start_of(address)", "start_u = reset_u"}, "afferent_chip.v");
    EXPECT_NE(simulated(chip), "");
}

TEST(VerilogExport, Fits256NeuronsAndATickOfAMillisecondOnAnIce40) {
    SKIP_WITHOUT("yosys");
    SKIP_WITHOUT("nextpnr-ice40");
    const ChipNeurons neurons = chip_of({"tick_us: 1000"}, "delta_g: 0.03", 256);
    EXPECT_LE(exported_cycles_per_tick(neurons), 24'000U) << "at 24 MHz";
    ExportedChip chip = exported_verilog(neurons);
    ASSERT_EQ(chip.failure_of("make -s ice40"), "");
    const std::string said = chip.said();
    std::smatch cells;
    ASSERT_TRUE(std::regex_search(said, cells, std::regex("ICESTORM_LC: *([0-9]+)/"))) << said;
    EXPECT_LE(std::stoi(cells[1]), 1500);
    EXPECT_NE(said.find("(PASS at 24.00 MHz)"), std::string::npos) << said;
}

const Change changes_of_core[] = {
    // rounding
    {"even & half & (rest | high[0])", "even & half"},
    {"even & half & (rest | high[0])", "even & half & rest"},
    {"even & half & (rest | high[0])", "1'b0"},
    {"rest <= rest | half;", "rest <= half;"},
    {"rounded > one ? {W{1'b0}} : one - rounded", "one - rounded"},
    // saturation
    {"rounded < lowest ? lowest : rounded", "rounded"},
    {"rounded > highest ? highest : rounded", "rounded > highest ? lowest : rounded"},
    {"raised_g > g_most ? g_most : raised_g", "raised_g"},
    // threshold and reset
    {"new_u >= threshold", "new_u > threshold"},
    {"fires ? reset_u : new_u", "fires ? reset_u + 1 : new_u"},
    {"fires ? new_g + g_jump : new_g", "new_g"},
    // order
    {"multiply(shunted - b", "multiply(u - b"},
    {"high <= high + b;", "high <= rounded + b;"},
    {"all ? u : rounded", "rounded"},
    {"multiply(conductance, rounded[M-1:0]", "multiply(conductance, g[M-1:0]"},
    // refractory period
    {"refractory != 0 ? u : rounded <", "rounded <"},
    {"refractory - 1'b1", "refractory"},
    {"fires ? refractory_ticks", "fires ? refractory_ticks - 1'b1"},
    // width and sign
    {"{sum[W-1], sum}", "{1'b0, sum}"},
    {"if (reads) first <= first + 1'b1;", "if (ready) first <= first + 1'b1;"},
    // events, while their queue is full
    {"!(fires && fifo_full)", "1'b1"},
    {"now <= now + 1'b1;", ""},
};

TEST(VerilogExport, IsNotEqualOnceItsArithmeticIsChanged) {
    SKIP_WITHOUT("iverilog");
    // Many that fire at once; with so much adaptation that it takes all of v at a tick; and until g is as
    // large as it can be. The last is simulated the longest, and only where the others have told nothing.
    ExportedChip chips[] = {
        exported_verilog(chip_of({"tick_us: 1000"}, "delta_g: 0", 8), {.busy = 60, .silent = 1, .read = 0}),
        exported_verilog(chip_below_e_k("2")),
        exported_verilog(chip_below_e_k("0.03"), {.busy = 1200, .silent = 1, .read = 0})};
    for (ExportedChip& chip : chips) EXPECT_EQ(simulated(chip), "");
    for (const Change& change : changes_of_core) {
        std::string said;
        for (ExportedChip& chip : chips) {
            if (said.find("differ") != std::string::npos) break;
            said += chip.once_changed(change, "afferent_chip.v", simulated);
        }
        EXPECT_NE(said.find("differ"), std::string::npos) << change.from << " -> " << change.to << "\n"
                                                          << said;
    }
}

}  // namespace
}  // namespace afferent
