#include "bench/chip_bench.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <optional>
#include <ostream>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "afferent/chip/c_export.hpp"
#include "afferent/chip/verilog_export.hpp"
#include "afferent/io/pictures/scatter_picture.hpp"
#include "bench/comparison.hpp"
#include "bench/error_scene.hpp"
#include "bench/force_error.hpp"
#include "bench/solver.hpp"
#include "bench/table_file.hpp"
#include "bench/truth.hpp"

namespace afferent::bench {
namespace {

// So many neurons share a core, and so many are counted at once, so that the timer is fine enough.
constexpr int many = 256;

// Runs each tick between two looks at a timer of 25 MHz. QEMU takes a nanosecond for an instruction.
constexpr const char* counting_program = R"(#include <stdio.h>
#include "afferent_chip.h"
#define TIMER(offset) (*(volatile uint32_t *)(0x40000000 + (offset)))
static afferent_chip chip;
static uint16_t fired[AFFERENT_NEURONS];
static uint32_t random_number = 1;
int main(void) {
    unsigned long tick, most = 0, events = 0, silent = 0;
    unsigned long long silent_counts = 0;
    const long largest = (1l << (AFFERENT_INPUT_BITS - 1)) - 1;
    afferent_reset(&chip);
    TIMER(8) = 0xffffffff, TIMER(0) = 1;
    for (tick = 0; tick < 3000; ++tick) {
        uint32_t begin, counts, count;
        uint16_t i;
        /* Silence, as much as there is, and inputs at random. */
        for (i = 0; i < AFFERENT_NEURONS; ++i) {
            random_number = random_number * 1664525u + 1013904223u;
            if (tick == 1000) afferent_set_input(&chip, i, largest);
            if (tick >= 2000) afferent_set_input(&chip, i, (long)(random_number >> 8) % largest);
        }
        begin = TIMER(4);
        count = afferent_tick(&chip, fired);
        counts = begin - TIMER(4);
        if (counts > most) most = counts;
        if (count == 0) silent_counts += counts, ++silent;
        events += count;
    }
    printf("%.3f %.3f %lu\n", 40.0 * (double)silent_counts / (double)silent / AFFERENT_NEURONS,
           40.0 * (double)most / AFFERENT_NEURONS, events);
    return 0;
}
)";

constexpr const char* sized_program = R"(#include "afferent_encoder.h"
#include "afferent_wire.h"
static afferent_chip chip;
static uint16_t fired[AFFERENT_NEURONS];
volatile uint32_t reading;
volatile uint8_t line;
#ifdef WIRE
static afferent_wire wire;
static void send(const uint8_t *bytes, uint32_t count) {
    while (count-- > 0) line = *bytes++;
}
#endif
int main(void) {
    afferent_reset(&chip);
#ifdef WIRE
    afferent_wire_reset(&wire);
    afferent_wire_hello(send);
#endif
    for (;;) {
        const uint32_t count = afferent_tick(&chip, fired);
#ifdef WIRE
        afferent_wire_tick(&wire, fired, count, send);
#endif
#ifdef ENCODER
        afferent_set_reading(&chip, (uint16_t)(count % AFFERENT_NEURONS), reading);
#else
        afferent_set_input(&chip, (uint16_t)(count % AFFERENT_NEURONS), (int32_t)reading);
#endif
    }
}
)";

struct Row {
    std::uint32_t bits;
    std::uint32_t tick_us;
    double median_us = 0;
    double rms_us = 0;
    std::size_t missed = 0;
    std::size_t extra = 0;
    std::optional<double> force_rms_n = {};
    std::uint32_t ram_bytes = 0;  // of a neuron
    // Instructions of a neuron and tick, without a spike and at most.
    std::optional<double> typical = {};
    std::optional<double> most = {};
    // Bytes of flash of the neurons alone, with the encoder, and with encoder and wire; bytes of RAM of all
    // three.
    std::optional<double> neurons_bytes = {};
    std::optional<double> encoder_bytes = {};
    std::optional<double> whole_bytes = {};
    std::optional<double> whole_ram = {};
    std::optional<double> logic_cells = {};
    std::optional<double> block_rams = {};
    std::optional<double> highest_mhz = {};
    double enough_mhz = 0;

    double ticks_per_s() const { return 1e6 / tick_us; }
};

bool has(const char* program) {
    return std::system(("command -v " + std::string(program) + " >/dev/null 2>&1").c_str()) == 0;
}

// What a command says, run in that folder.
std::string said_by(const std::filesystem::path& folder, const std::string& command) {
    const std::string in = "cd '" + folder.string() + "' && (" + command + ") >bench.said 2>bench.errors";
    const bool succeeded = std::system(in.c_str()) == 0;
    std::ifstream file(folder / "bench.said");
    std::string said{std::istreambuf_iterator<char>(file), {}};
    if (!succeeded)
        throw std::runtime_error(folder.string() + ": " + command.substr(0, command.find(' ')) +
                                 " failed; bench.errors says why");
    return said;
}

void write(const std::filesystem::path& folder, const std::vector<ExportedFile>& files) {
    std::filesystem::create_directories(folder);
    for (const ExportedFile& file : files) std::ofstream(folder / file.name) << file.text;
}

double number_in(const std::string& text, const char* pattern) {
    std::smatch found;
    if (!std::regex_search(text, found, std::regex(pattern)))
        throw std::runtime_error("no " + std::string(pattern) + " in what was said: " + text);
    return std::stod(found[1]);
}

Scene with_arithmetic(Scene scene, const Row& row) {
    // Neurons that are too coarse to reach the scene's limit are measured all the same.
    scene.gain.accept_unreachable_limit = true;
    for (scene::Patch& patch : scene.patches) {
        if (!patch.neuron.fixed_point) patch.neuron.fixed_point.emplace();
        patch.neuron.fixed_point->tick_us = row.tick_us;
        patch.neuron.fixed_point->state_bits = row.bits;
        patch.neuron.fixed_point->decay_bits = std::max(16U, row.bits);
    }
    return scene;
}

// As bench error judges the solver of that width.
void measure_error(const ErrorScene& scene, const Trains& truth, Row& row) {
    const auto solver = make_solver({"fixed-" + std::to_string(row.bits), row.tick_us / 1e3});
    Trains trains(scene.workload.neurons);
    solver->prepare(scene.workload);
    solver->run(scene.workload, trains);
    Comparison errors;
    for (const std::size_t neuron : scene.judged) errors.add(truth[neuron], trains[neuron]);
    row.median_us = 1e6 * errors.quantile_s(0.5);
    row.rms_us = 1e6 * errors.rms_s();
    row.missed = errors.missed;
    row.extra = errors.extra;
    row.force_rms_n = force_rms_n(scene, trains);
}

// Linked with what the compiler's library adds, and a main that does nothing else.
void measure_size(const Plan& plan, const std::filesystem::path& folder, Row& row) {
    const ChipNeurons neurons = chip_neurons(plan);
    row.ram_bytes = exported_bytes_per_neuron(neurons);
    const ChipParts parts = chip_parts(plan, neurons);
    write(folder, export_c(neurons, parts, plan.scene.name));
    if (!has("arm-none-eabi-gcc")) return;
    if (!parts.encoder || !parts.wire)
        throw std::runtime_error("the scene has no encoder or no wire to export");
    std::ofstream(folder / "size.c") << sized_program;
    const auto sizes = [&](const char* defined) {
        return said_by(folder,
                       "arm-none-eabi-gcc -std=c99 -mcpu=cortex-m0 -mthumb -Os -ffunction-sections "
                       "-Wl,--gc-sections -nostartfiles -Wl,-emain " +
                           std::string(defined) +
                           " -o size.elf size.c afferent_chip.c afferent_encoder.c afferent_wire.c && "
                           "arm-none-eabi-size size.elf");
    };
    const auto flash = [](const std::string& said) { return number_in(said, R"(\n\s*(\d+))"); };
    row.neurons_bytes = flash(sizes(""));
    row.encoder_bytes = flash(sizes("-DENCODER"));
    const std::string all = sizes("-DENCODER -DWIRE");
    row.whole_bytes = flash(all);
    row.whole_ram = number_in(all, R"(\n\s*\d+\s+\d+\s+(\d+))");
}

ChipNeurons many_neurons(const Row& row) {
    std::string text =
        "duration_s: 1 source { profile { point { time_s: 0 force_n: 0 } } } patch { name: \"a\" elements: " +
        std::to_string(many);
    for (int i = 0; i < many; ++i) text += " share: 0.001";
    return chip_neurons(make_plan(with_arithmetic(
        Scene::from_text(text + " neuron { tau_m_ms: 10 tau_g_ms: 500 delta_g: 0.03 } }"), row)));
}

void count_instructions(const ChipNeurons& neurons, const std::filesystem::path& folder, Row& row) {
    if (!has("arm-none-eabi-gcc") || !has("qemu-system-arm")) return;
    write(folder, export_c(neurons, {}, "count"));
    std::ofstream(folder / "count.c") << counting_program;
    const std::string said =
        said_by(folder,
                "arm-none-eabi-gcc -std=c99 -O2 -mcpu=cortex-m3 -mthumb --specs=rdimon.specs "
                "-Wl,--section-start=.vectors=0 -Wl,-Ttext-segment=0x1000 -o count.elf count.c "
                "afferent_chip.c cortex_m.c && "
                "timeout 120 qemu-system-arm -M mps2-an385 -nographic -icount shift=0 "
                "-semihosting-config enable=on,target=native -kernel count.elf");
    std::istringstream numbers(said);
    double typical = 0;
    double most = 0;
    std::size_t events = 0;
    if (!(numbers >> typical >> most >> events) || events == 0)
        throw std::runtime_error(folder.string() + ": the neurons have not fired: " + said);
    row.typical = typical;
    row.most = most;
}

void count_cells(const ChipNeurons& neurons, const std::filesystem::path& folder, Row& row) {
    row.enough_mhz = static_cast<double>(exported_cycles_per_tick(neurons)) * row.ticks_per_s() / 1e6;
    if (!has("yosys") || !has("nextpnr-ice40")) return;
    write(folder, export_verilog(neurons, "count"));
    const std::string said = said_by(folder, "make -s ice40");
    row.logic_cells = number_in(said, R"(ICESTORM_LC:\s*(\d+)/)");
    row.block_rams = number_in(said, R"(ICESTORM_RAM:\s*(\d+)/)");
    row.highest_mhz = number_in(said, R"(clock[^:]*: ([0-9.]+) MHz)");
}

std::string shown_or_dash(std::optional<double> value, int digits) {
    if (!value) return "-";
    std::ostringstream text;
    text << std::fixed << std::setprecision(digits) << *value;
    return text.str();
}

void print(const std::vector<Row>& rows, std::ostream& report) {
    report << "Spike times, us; force, N; instructions of a neuron and tick on a Cortex-M3; bytes of flash "
              "on a Cortex-M0,\n"
              "of the neurons, with the encoder, and with the wire, and of RAM, for a neuron and of all; "
           << many << " neurons on an iCE40 HX8K, MHz that it can and that it has to have\n";
    const auto line = [&](const std::vector<std::string>& cells) {
        for (const std::string& cell : cells) report << std::setw(9) << cell;
        report << '\n';
    };
    line({"bits", "tick ms", "median", "rms", "missed", "extra", "force", "instr.", "at most", "neurons",
          "encoder", "wire", "a neuron", "all", "cells", "RAMs", "can", "has to"});
    for (const Row& row : rows)
        line({std::to_string(row.bits), shown_or_dash(row.tick_us / 1e3, 1), shown_or_dash(row.median_us, 1),
              shown_or_dash(row.rms_us, 1), std::to_string(row.missed), std::to_string(row.extra),
              shown_or_dash(row.force_rms_n, 4), shown_or_dash(row.typical, 1), shown_or_dash(row.most, 1),
              shown_or_dash(row.neurons_bytes, 0), shown_or_dash(row.encoder_bytes, 0),
              shown_or_dash(row.whole_bytes, 0), std::to_string(row.ram_bytes),
              shown_or_dash(row.whole_ram, 0), shown_or_dash(row.logic_cells, 0),
              shown_or_dash(row.block_rams, 0), shown_or_dash(row.highest_mhz, 1),
              shown_or_dash(row.enough_mhz, 1)});
}

void write_table(const std::vector<Row>& rows, const std::filesystem::path& out) {
    TableFile file(out / "chip.csv",
                   {"state_bits", "tick_us", "median_us", "rms_us", "missed", "extra", "force_rms_n",
                    "instructions_typical", "instructions_most", "neurons_flash_bytes", "encoder_flash_bytes",
                    "flash_bytes", "ram_bytes_per_neuron", "ram_bytes", "logic_cells", "block_rams",
                    "highest_mhz", "enough_mhz"});
    const auto cell = [](std::optional<double> value) { return value ? number(*value) : ""; };
    for (const Row& row : rows)
        file.row({std::to_string(row.bits), std::to_string(row.tick_us), number(row.median_us),
                  number(row.rms_us), std::to_string(row.missed), std::to_string(row.extra),
                  cell(row.force_rms_n), cell(row.typical), cell(row.most), cell(row.neurons_bytes),
                  cell(row.encoder_bytes), cell(row.whole_bytes), std::to_string(row.ram_bytes),
                  cell(row.whole_ram), cell(row.logic_cells), cell(row.block_rams), cell(row.highest_mhz),
                  number(row.enough_mhz)});
    file.close();
}

// Instructions a second in firmware, and cycles a second in the core: of one neuron, so that both have one
// axis.
void draw_chip(const std::vector<Row>& rows, const std::filesystem::path& out, std::ostream& report) {
    ScatterPicture picture{"Error against what a chip computes: ticks of 1 ms, then of 0.1 ms",
                           "of one neuron in a second: instructions of a Cortex-M3, or cycles of the core",
                           "RMS error of a spike time, µs",
                           {}};
    for (const bool firmware : {true, false})
        for (const std::uint32_t bits : {8U, 12U, 16U, 24U}) {
            ScatterPicture::Series series{
                std::to_string(bits) + (firmware ? " bits, C on a Cortex-M3" : " bits, the core"), {}};
            series.kind = firmware ? 0 : 1;
            for (const Row& row : rows) {
                const double x =
                    firmware ? row.typical.value_or(0) * row.ticks_per_s() : row.enough_mhz * 1e6 / many;
                if (row.bits == bits) series.points.push_back({x, row.rms_us});
            }
            picture.series.push_back(std::move(series));
        }
    const Drawing drawing = draw(picture, out / "chip");
    if (drawing.outcome == Drawn::no_gnuplot) report << "No picture: gnuplot is not installed\n";
    if (drawing.outcome == Drawn::failed) report << "No picture: " << drawing.message << '\n';
}

}  // namespace

void run_chip_bench(const ChipBench& bench, std::ostream& report) {
    const Scene scene = Scene::from_file(bench.scene);
    const ErrorScene grasp = error_scenes(bench.quick).front();
    Trains truth(grasp.workload.neurons);
    for (const std::size_t neuron : grasp.judged) truth[neuron] = true_train(grasp.workload, neuron);
    std::vector<Row> rows;
    for (const std::uint32_t tick_us : {1000U, 100U})
        for (const std::uint32_t bits : {8U, 12U, 16U, 24U})
            if (!bench.quick || (bits == 16 && tick_us == 1000))
                rows.push_back({.bits = bits, .tick_us = tick_us});
    for (std::size_t i = 0; i < rows.size(); ++i) {
        Row& row = rows[i];
        const auto folder = [&](const char* what) {
            return bench.out / "chip" /
                   (std::to_string(row.bits) + "_bits_" + std::to_string(row.tick_us) + "_us_" + what);
        };
        bench.progress(static_cast<double>(i) / static_cast<double>(rows.size()));
        measure_error(grasp, truth, row);
        measure_size(make_plan(with_arithmetic(scene, row)), folder("scene"), row);
        const ChipNeurons neurons = many_neurons(row);
        count_instructions(neurons, folder("c"), row);
        count_cells(neurons, folder("verilog"), row);
    }
    bench.progress(1);
    report << "Force error of the exact neuron, N: " << shown_or_dash(force_rms_n(grasp, truth), 4) << '\n';
    print(rows, report);
    for (const char* const program : {"arm-none-eabi-gcc", "qemu-system-arm", "yosys", "nextpnr-ice40"})
        if (!has(program)) report << program << " is not installed: scripts/install-dependencies.sh chip\n";
    write_table(rows, bench.out);
    draw_chip(rows, bench.out, report);
}

}  // namespace afferent::bench
