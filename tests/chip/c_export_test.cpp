// The exported C against its vectors, which come from the emulator: compiled, run, and changed.
#include "afferent/chip/c_export.hpp"

#include <gtest/gtest.h>

#include <sstream>

#include "afferent/scene/scene_error.hpp"
#include "tests/chip/exported_chip.hpp"

namespace afferent {
namespace {

// Compiles it and compares it with its vectors. Empty: they are equal; otherwise what is said of it.
std::string check(ExportedChip& chip, const std::string& flags = "-O1") {
    return chip.failure_of("cc -std=c99 -Wall -Wextra -pedantic -Werror " + flags +
                           " -o check check.c afferent_chip.c && ./check vectors.txt");
}

ExportedChip exported_c(const ChipNeurons& neurons) {
    return {neurons, {}, export_c(neurons, {}, "test"), VectorLength::full(neurons)};
}

std::string check(const ChipNeurons& neurons, const std::string& flags = "-O1") {
    ExportedChip chip = exported_c(neurons);
    return check(chip, flags);
}

// Products that overflow, and shifts that C does not define, end the check.
constexpr const char* undefined_ends = "-O1 -fsanitize=undefined -fno-sanitize-recover=all";

class ExportedWidth : public testing::TestWithParam<const char*> {};

TEST_P(ExportedWidth, IsEqualToTheEmulatorToTheBit) {
    for (const char* const rounding : {"HALF_EVEN", "TRUNCATION"}) {
        const std::string fixed_point = GetParam() + std::string(" rounding: ") + rounding;
        EXPECT_EQ(check(chip_of({fixed_point}), undefined_ends), "") << fixed_point;
        EXPECT_EQ(check(chip_of({fixed_point}, "delta_g: 0.03 refractory_ms: 3")), "") << fixed_point;
    }
}

INSTANTIATE_TEST_SUITE_P(All, ExportedWidth, testing::ValuesIn(widths_of_chips),
                         [](const auto& each) { return std::to_string(each.index); });

TEST(CExport, HasNeuronsOfSeveralWidths) {
    const ChipNeurons neurons = chip_of_several_widths();
    EXPECT_EQ(neurons.groups.size(), 3U);
    EXPECT_EQ(check(neurons, undefined_ends), "");
}

// The vectors have everything but the hour of silence.
TEST(CExport, IsEqualOnACortexMAndOnRiscV) {
    SKIP_WITHOUT("arm-none-eabi-gcc");
    SKIP_WITHOUT("riscv64-unknown-elf-gcc");
    SKIP_WITHOUT("qemu-system-arm");
    SKIP_WITHOUT("qemu-system-riscv32");
    const ChipNeurons neurons = chip_of_several_widths();
    ExportedChip chip(neurons, {}, export_c(neurons, {}, "test"), VectorLength::of_simulation(neurons));
    EXPECT_EQ(chip.failure_of("make -s cortex-m"), "");
    EXPECT_EQ(chip.failure_of("make -s cortex-m CORTEX=cortex-m0"), "");
    EXPECT_EQ(chip.failure_of("make -s riscv"), "");
    EXPECT_NE(chip.said().find("6 neurons, "), std::string::npos) << chip.said();
    // A change is noticed there, too.
    chip.make({"u >= c->threshold", "u > c->threshold"}, "afferent_chip.c");
    EXPECT_NE(chip.failure_of("make -s cortex-m").find("tick "), std::string::npos);
    EXPECT_NE(chip.failure_of("make -s riscv").find("tick "), std::string::npos);
}

// Of all widths that the tests go through, by ticks, which one chip has in common.
TEST(CExport, IsProvedNotToOverflow) {
    SKIP_WITHOUT("frama-c");
    for (const char* const tick : {"tick_us: 1000 ", "tick_us: 100 "}) {
        std::vector<std::string> widths;
        for (const std::string width : widths_of_chips)
            for (const char* const rounding : {" rounding: HALF_EVEN", " rounding: TRUNCATION"})
                if (width.starts_with(tick)) widths.push_back(width + rounding);
        ASSERT_GE(widths.size(), 4U);
        for (const char* const neuron :
             {"delta_g: 0.03", "delta_g: 0",
              "refractory_ms: 2 e_k_mv: -69 v_r_mv: -70 v_th_mv: -55 delta_g: 0.03"}) {
            const ChipNeurons neurons = chip_of(widths, neuron, 1);
            EXPECT_EQ(neurons.groups.size(), widths.size());
            ExportedChip chip(neurons, {}, export_c(neurons, {}, "test"),
                              {.busy = 1, .silent = 1, .read = 0});
            EXPECT_EQ(chip.failure_of("make -s proof"), "") << tick << neuron;
        }
    }
    // So that the proof says something: numbers of half the width are refused, and a state that is not held.
    const auto proof = [](ExportedChip& chip) { return chip.failure_of("make -s proof"); };
    const ChipNeurons neurons = chip_of({"tick_us: 1000"});
    ExportedChip chip(neurons, {}, export_c(neurons, {}, "test"), {.busy = 1, .silent = 1, .read = 0});
    EXPECT_EQ(proof(chip), "");
    for (const Change& change :
         {Change{"typedef int64_t wide", "typedef int32_t wide"},
          Change{"(wide)(u < c->lowest), c->lowest", "(wide)(u < c->lowest), c->lowest - 1"},
          Change{"(wide)(g > c->g_most), c->g_most", "(wide)(g > c->g_most + 1), c->g_most"}})
        EXPECT_NE(chip.once_changed(change, "afferent_chip.c", proof), "") << change.to;
}

TEST(CExport, IsNotChangedByAName) {
    const ChipNeurons neurons = chip_of({"tick_us: 10000"});
    const auto header = [&](const std::string& name) { return export_c(neurons, {}, name).front().text; };
    EXPECT_EQ(header("*/ #error \n\\"), header("__ #error __"));
}

TEST(CExport, TakesFewBytes) {
    EXPECT_EQ(exported_bytes_per_neuron(chip_of({""})), 12U);
    EXPECT_EQ(exported_bytes_per_neuron(chip_of({"state_bits: 8"})), 6U);
    EXPECT_EQ(exported_bytes_per_neuron(chip_of({"state_bits: 32"})), 24U);
}

TEST(CExport, SaysWhatItCannotExport) {
    const auto refusal = [](const std::string& text) {
        try {
            chip_neurons(make_plan(Scene::from_text(text)));
        } catch (const SceneError& error) {
            return std::string(error.what());
        }
        return std::string("accepted");
    };
    const std::string source = "duration_s: 1 source { profile { point { time_s: 0 force_n: 0 } } } ";
    const std::string floating = refusal(source + "patch { name: \"a\" elements: 1 share: [1] }");
    EXPECT_NE(floating.find("patch \"a\": a chip's neurons are integers"), std::string::npos) << floating;
    const std::string nerve =
        refusal(source + "patch { name: \"a\" elements: 1 share: [1] neuron { fixed_point {} } nerve {} }");
    EXPECT_NE(nerve.find("patch \"a\": a chip's events leave as its neurons fire"), std::string::npos)
        << nerve;
    const std::string ticks =
        refusal(source +
                "patch { name: \"a\" elements: 1 share: [0.5] neuron { fixed_point {} } }"
                "patch { name: \"b\" elements: 1 share: [0.5] neuron { fixed_point { tick_us: 200 } } }");
    EXPECT_NE(ticks.find("patch \"b\": neuron.fixed_point.tick_us must be the same"), std::string::npos)
        << ticks;
}

TEST(ChipVectors, HaveWhatBreaksImplementations) {
    const ChipNeurons neurons = chip_of({"tick_us: 1000 state_bits: 16"});
    const FixedPointLif::Codes& codes = neurons.groups[0].neuron.codes();
    const Vectors vectors = chip_vectors(neurons, {}, 1, VectorLength::full(neurons));
    EXPECT_GE(vectors.ticks, 3'600'000) << "an hour";
    const std::int64_t largest = (1 << 20) - 1;
    std::size_t most = 0;
    std::size_t least = 0;
    std::size_t events = 0;
    std::size_t at_spikes = 0;
    std::size_t lowest = 0;
    std::int64_t spike = 0;
    for (const VectorRecord& record : vectors.records) {
        if (record.address != 0) continue;
        if (record.kind == VectorRecord::Kind::event) ++events, spike = record.tick;
        if (record.kind == VectorRecord::Kind::input) {
            most += record.input == largest;
            least += record.input == -largest - 1;
            at_spikes += record.tick == spike + 1;
        }
        lowest += record.kind == VectorRecord::Kind::state && record.state.u == codes.lowest;
    }
    EXPECT_GT(most, 2U);
    EXPECT_GT(least, 2U);
    EXPECT_GT(events, 200U);
    EXPECT_GT(at_spikes, 10U);
    EXPECT_GT(lowest, 2U);
}

TEST(ChipVectors, DifferBySeedAndNotByRun) {
    const ChipNeurons neurons = chip_of({"tick_us: 10000"});
    const auto text = [&](std::uint64_t seed) {
        std::ostringstream out;
        write(chip_vectors(neurons, {}, seed, VectorLength::full(neurons)), neurons.count(), out);
        return out.str();
    };
    EXPECT_EQ(text(1), text(1));
    EXPECT_NE(text(1), text(2));
}

// Changes of the arithmetic, each of which the vectors find.
const Change changes[] = {
    // rounding
    {"(even << (bits - (uint32_t)even)) - even +", "(even << (bits - (uint32_t)even)) +"},
    {"- even + ((product >> bits) & even)", "- even + (1 & even)"},
    {"- even + ((product >> bits) & even)", "- even"},
    {"even &= bits != 0;", "even = 0;"},
    {"even &= bits != 0;", "even = bits != 0; product += 1;"},
    {"kept = chosen(-(wide)(kept < 0), 0, kept);", ""},
    // saturation
    {"u = chosen(-(wide)(u < c->lowest), c->lowest, u);", ""},
    {"u = chosen(-(wide)(u > c->highest), c->highest, u);", "if (u > c->highest) u = c->lowest;"},
    {"(wide)(u < c->lowest), c->lowest", "(wide)(u < c->lowest), c->lowest + 1"},
    {"(wide)(g > c->g_most), c->g_most", "(wide)(g > c->g_most), c->g_most - 1"},
    {"g = chosen(-(wide)(g > c->g_most), c->g_most, g);", "g &= c->g_most;"},
    {"n->input * (c->one", "(n->input & ~1) * (c->one"},
    // threshold and reset
    {"u >= c->threshold", "u > c->threshold"},
    {"u >= c->threshold", "u >= c->threshold - 1"},
    {"chosen(fires, c->reset, u)", "chosen(fires, u - c->threshold, u)"},
    {"chosen(fires, c->reset, u)", "chosen(fires, c->reset + 1, u)"},
    // order
    {"n->g * c->g_decay", "(n->g + 1) * c->g_decay"},
    {"shifted(g * c->conductance", "shifted(n->g * c->conductance"},
    {"u = shifted(n->u * kept, c->decay_bits, c->even);", "u = n->u;"},
    {"u = shifted(u * c->v_decay + n->input * (c->one - c->v_decay), c->decay_bits, c->even);",
     "u = shifted(u * c->v_decay, c->decay_bits, c->even) + shifted(n->input * (c->one - c->v_decay), "
     "c->decay_bits, c->even);"},
    {"n->u * kept", "(n->u - n->input) * kept"},
    {"g += c->g_jump & fires;", "g += c->g_jump;"},
    {"g += c->g_jump & fires;", ""},
    // refractory
    {"u = chosen(waits, n->u, u);", ""},
    {"u = chosen(waits, n->u, u);", "g = chosen(waits, n->g, g);u = chosen(waits, n->u, u);"},
    {"chosen(fires, (wide)c->refractory, n->refractory + waits)",
     "chosen(fires, (wide)c->refractory - 1, n->refractory + waits)"},
    {"chosen(fires, (wide)c->refractory, n->refractory + waits)",
     "chosen(fires, (wide)c->refractory, n->refractory - 1)"},
    // events
    {"fired[count] = (uint16_t)i;", "fired[count] = (uint16_t)(i ^ 1);"},
    {"count -= (uint32_t)fires;", "count = fires ? 1 : count;"},
    // width
    {"n->g = (uint16_t)g;", "n->g = (uint8_t)g;"},
    {"n->u = (int32_t)chosen", "n->u = (int16_t)chosen"},
    {"c->one - c->v_decay), c->decay_bits", "c->one - c->v_decay), c->decay_bits + 1"},
};

TEST(ChipVectors, FindEachChangeOfTheArithmetic) {
    // Once with so much adaptation that it takes all of v at a tick.
    ASSERT_EQ(chip_widths(chip_below_e_k("0.03")).u_bits, 17U);
    ExportedChip chips[] = {exported_c(chip_below_e_k("0.03")), exported_c(chip_below_e_k("2"))};
    EXPECT_GE(std::size(changes), 30U);
    for (const Change& change : changes) {
        std::string said;
        for (ExportedChip& chip : chips) {
            if (said.find("tick") != std::string::npos) break;
            said += chip.once_changed(change, "afferent_chip.c", [](ExportedChip& changed) {
                return check(changed, "-O1 -Wno-unused-variable -Wno-sign-compare -Wno-unused-parameter");
            });
        }
        EXPECT_NE(said.find("tick"), std::string::npos) << change.from << " -> " << change.to << "\n" << said;
    }
}

}  // namespace
}  // namespace afferent
