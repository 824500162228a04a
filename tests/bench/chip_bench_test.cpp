// The quick form of the benchmark of chips: its table has what its programs said, and the neuron its
// promises.
#include "bench/chip_bench.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <sstream>

#include "bench/table_file.hpp"
#include "tests/temporary_folder.hpp"

namespace afferent {
namespace {

TEST(ChipBench, TellsErrorBesideSilicon) {
    for (const char* const program : {"arm-none-eabi-gcc", "qemu-system-arm", "yosys", "nextpnr-ice40"})
        if (std::system(("command -v " + std::string(program) + " >/dev/null").c_str()) != 0)
            GTEST_SKIP() << program << " is not installed: scripts/install-dependencies.sh chip";
    const Folder folder;
    std::ostringstream report;
    bench::ChipBench bench;
    bench.out = folder / "bench";
    bench.quick = true;
    bench.scene = AFFERENT_SOURCE_DIR "/examples/chip.txtpb";
    bench::run_chip_bench(bench, report);
    const auto rows = bench::read_rows(folder / "bench/chip.csv");
    ASSERT_EQ(rows.size(), 1U) << report.str();
    std::map<std::string, double> row;
    for (const auto& [column, cell] : rows[0]) row[column] = std::stod(cell);
    EXPECT_GT(row["rms_us"], 0);
    EXPECT_GT(row["instructions_typical"], 20);
    EXPECT_LE(row["instructions_most"], 1.1 * row["instructions_typical"]);
    EXPECT_LE(row["ram_bytes_per_neuron"], 16);
    EXPECT_LE(row["encoder_flash_bytes"], 3 * 1024);
    EXPECT_LE(row["flash_bytes"], 8 * 1024);
    EXPECT_LE(row["logic_cells"], 1500);
    EXPECT_GE(row["highest_mhz"], 24);
    EXPECT_GE(row["highest_mhz"], row["enough_mhz"]);
}

}  // namespace
}  // namespace afferent
