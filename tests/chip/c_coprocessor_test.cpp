// The exported C beyond the neurons: readings to inputs, and events to packets on a line.
#include <gtest/gtest.h>

#include "afferent/chip/c_export.hpp"
#include "afferent/hand/sensor.hpp"
#include "tests/chip/exported_chip.hpp"

namespace afferent {
namespace {

// A scene's chip with all its parts.
struct WholeChip {
    explicit WholeChip(const Scene& scene)
        : plan(make_plan(scene)), neurons(chip_neurons(plan)), parts(chip_parts(plan, neurons)) {}

    ExportedChip exported(const VectorLength& length) const {
        return {neurons, parts, export_c(neurons, parts, "test"), length};
    }

    Plan plan;
    ChipNeurons neurons;
    ChipParts parts;
};

constexpr const char* sources = "check.c afferent_chip.c afferent_encoder.c afferent_wire.c";

std::string said_of(ExportedChip& chip, const std::string& flags = "-O1") {
    return chip.failure_of("cc -std=c99 -Wall -Wextra -pedantic -Werror " + flags + " -o check " + sources +
                           " && ./check vectors.txt");
}
constexpr const char* sanitized = "-O1 -fsanitize=address,undefined -fno-sanitize-recover=all";

// As much as packets need: touches begin and end, and a few hundred heartbeats pass.
constexpr VectorLength touches{.busy = 3000, .silent = 20'000, .read = 4096};

WholeChip chip_of_text(const std::string& link, const std::string& patch = "", int tick_us = 1000,
                       const std::string& rest = "") {
    return WholeChip(Scene::from_text(
        "duration_s: 1 source { profile { point { time_s: 0 force_n: 0 } } } link { tcp { port: 1 } " + link +
        " } patch { name: \"a\" elements: 2 share: [0.4, 0.4] " + patch +
        " neuron { tau_m_ms: 10 tau_g_ms: 500 delta_g: 0.03 fixed_point { tick_us: " +
        std::to_string(tick_us) + " } } }" + rest));
}

TEST(ExportedCoprocessor, IsTheExamplesToTheByte) {
    const WholeChip chip(Scene::from_file(AFFERENT_SOURCE_DIR "/examples/chip.txtpb"));
    ASSERT_TRUE(chip.parts.encoder) << chip.parts.why_no_encoder;
    ASSERT_TRUE(chip.parts.wire) << chip.parts.why_no_wire;
    ExportedChip exported = chip.exported(touches);
    EXPECT_EQ(said_of(exported, sanitized), "");
    EXPECT_EQ(exported.said().find(" 0 bytes on the line"), std::string::npos) << exported.said();
}

struct Wire {
    const char* name;
    const char* link;
    int tick_us;
};

class ExportedWire : public testing::TestWithParam<Wire> {};

TEST_P(ExportedWire, HasTheBytesOfThePacketizer) {
    const WholeChip chip = chip_of_text(GetParam().link, "", GetParam().tick_us);
    ASSERT_TRUE(chip.parts.wire) << chip.parts.why_no_wire;
    ExportedChip exported = chip.exported(touches);
    EXPECT_EQ(said_of(exported, sanitized), "");
}

INSTANTIATE_TEST_SUITE_P(
    All, ExportedWire,
    testing::Values(Wire{"Default", "", 1000}, Wire{"FixedWidth", "encoding: FIXED_WIDTH", 100},
                    Wire{"BeginsOfTouchesAtOnce", "packet_ms: 20 prompt_ms: 2 heartbeat_ms: 30", 1000},
                    Wire{"SeveralParts", "packet_ms: 20 packet_events: 3", 1000},
                    Wire{"SpansOfATick", "packet_ms: 1 heartbeat_ms: 1", 1000},
                    Wire{"SpansOfATickAndHeartbeatsOfTen", "packet_ms: 1 heartbeat_ms: 10", 1000},
                    Wire{"CoarserTicksOfTheLink", "tick_us: 1000", 100},
                    Wire{"FinerTicksOfTheLink", "tick_us: 1 packet_ms: 30 heartbeat_ms: 30", 500}),
    [](const auto& each) { return each.param.name; });

// The curve of a force-sensitive resistor, a line, a table of counts, and elements that do not work.
TEST(CountsEncoder, HasTheEmulatorsInputForEachReading) {
    const char* const sensors[] = {"force_resistance {}",
                                   "force_resistance { divider_ohm: 100 half_force_n: 3 } adc_bits: 10", "",
                                   "adc_bits: 16 calibration { counts: 0 } calibration { counts: 9000 "
                                   "force_n: 2 } calibration { counts: 60000 }",
                                   "dead_element: 0 stuck_element { element: 1 force_n: 2.5 }"};
    for (const char* const sensor : sensors) {
        const WholeChip chip = chip_of_text("", "sensor { " + std::string(sensor) + " }");
        ASSERT_TRUE(chip.parts.encoder) << sensor << ": " << chip.parts.why_no_encoder;
        const PatchPlan& patch = chip.plan.patches[0];
        const Sensor curve(patch.sensor);
        for (Address i = 0; i < 2; ++i) {
            const FixedPointLif& neuron = chip.neurons.neuron(i);
            const CountsCurve& found = chip.parts.encoder->curve_of(i);
            std::uint32_t differ = 0;
            for (std::uint32_t counts = 0; counts <= curve.highest_count(); ++counts) {
                double force_n =
                    patch.calibration ? patch.calibration->force_n(counts) : curve.force_n(counts);
                if (!patch.sensor.dead_element.empty()) force_n = i == 0 ? 0 : 2.5;
                differ += found.input(counts) != neuron.input(patch.gain() * force_n + patch.bias_mv());
            }
            EXPECT_EQ(differ, 0U) << sensor;
            EXPECT_EQ(found.input(100'000'000), found.input(found.highest_count)) << sensor;
        }
        ExportedChip exported = chip.exported({.busy = 100, .silent = 1, .read = 4096});
        EXPECT_EQ(said_of(exported, sanitized), "") << sensor;
    }
}

TEST(CountsEncoder, IsLeftOutWithTheReason) {
    const auto why = [](const std::string& patch) { return chip_of_text("", patch).parts.why_no_encoder; };
    const char* const transient =
        " patch { name: \"b\" elements_of: \"a\" encoder { transient { gain_mv_s_per_n: 1 } } neuron { "
        "fixed_point "
        "{ tick_us: 1000 } } }";
    EXPECT_NE(
        chip_of_text("", "", 1000, transient).parts.why_no_encoder.find("patch \"b\": its encoder is not"),
        std::string::npos);
    const char* const dynamic =
        " patch { name: \"b\" elements_of: \"a\" encoder { sustained { dynamic {} } } neuron { fixed_point "
        "{ tick_us: 1000 } } }";
    EXPECT_NE(chip_of_text("", "", 1000, dynamic).parts.why_no_encoder.find("without a dynamic term"),
              std::string::npos);
    EXPECT_NE(why("spread { gain { normal { sd: 0.1 } } }").find("one element of their own"),
              std::string::npos)
        << why("spread { gain { normal { sd: 0.1 } } }");
    std::string scattered = "sensor { ";
    for (int i = 0; i < 4096; ++i)
        scattered += "calibration { counts: " + std::to_string(i) +
                     " force_n: " + std::to_string(i * i * 7 % 997 * 0.001) + " } ";
    EXPECT_NE(why(scattered + "}").find("1024 pieces"), std::string::npos);
}

TEST(ExportedCoprocessor, LeavesOutAWireThatItCannotHave) {
    EXPECT_NE(chip_of_text("packet_ms: 1.5 heartbeat_ms: 9").parts.why_no_wire.find("must be a multiple"),
              std::string::npos);
    const WholeChip chip(Scene::from_text(
        "duration_s: 1 source { profile { point { time_s: 0 force_n: 0 } } } link { in_process {} } "
        "patch { name: \"a\" elements: 1 share: [1] neuron { fixed_point {} } }"));
    EXPECT_NE(chip.parts.why_no_wire.find("carries no packets"), std::string::npos);
    ExportedChip exported = chip.exported({.busy = 300, .silent = 1, .read = 300});
    EXPECT_EQ(exported.failure_of("make -s test"), "");
}

// Each is a fault that a reader of the page could make.
const Change changes_of_the_wire[] = {
    {"w->epoch != w->told_epoch", "0"},
    {"w->told != w->sent", "1"},
    {"implied_bits <= bits + 8", "implied_bits <= bits"},
    {"80 * (uint64_t)events", "70 * (uint64_t)events"},
    {"w->event[place - 1] > code", "0"},
    {"w->silence != implied_spans", "1"},
    {"if (++w->number == modulus)", "if (++w->number == modulus + 1)"},
    {"w->position - w->silence)", "w->position)"},
    {"modulus = 16383", "modulus = 16384"},
    {"end < begin + 254", "end < begin + 255"},
    {"return ~crc", "return crc"},
    {"w->first - (w->silence - spans)", "0"},
};

TEST(ExportedCoprocessor, HasVectorsThatFindEachChangeOfTheWire) {
    // Spans of a tick, so that positions come round; several ticks of the neurons in one of the wire; and
    // packets of more than 254 bytes without a zero.
    std::string many = " patch { name: \"b\" elements: 60 neuron { fixed_point { tick_us: 1000 } }";
    for (int i = 0; i < 60; ++i) many += " share: 0.001";
    ExportedChip chips[] = {
        chip_of_text("packet_ms: 1 heartbeat_ms: 10").exported(touches),
        chip_of_text("packet_ms: 20 prompt_ms: 2 tick_us: 1000", "", 100).exported(touches),
        chip_of_text("packet_ms: 30 heartbeat_ms: 30 encoding: FIXED_WIDTH", "", 1000, many + " }")
            .exported(touches)};
    for (const Change& change : changes_of_the_wire) {
        std::string said;
        for (ExportedChip& chip : chips) {
            if (said.find("on the line") != std::string::npos) break;
            // One of the chips has the other encoding.
            if (chip.file("afferent_wire.c").find(change.from) == std::string::npos) continue;
            said += chip.once_changed(change, "afferent_wire.c", [](ExportedChip& changed) {
                return said_of(changed, "-O1 -Wno-unused-variable -Wno-unused-parameter -Wno-type-limits");
            });
        }
        EXPECT_NE(said.find("on the line"), std::string::npos) << change.from << " -> " << change.to << said;
    }
}

}  // namespace
}  // namespace afferent
