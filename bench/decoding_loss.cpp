#include "bench/decoding_loss.hpp"

#include <algorithm>
#include <iomanip>
#include <mutex>
#include <thread>

#include "afferent/runtime/parallel.hpp"
#include "bench/decoding_bench.hpp"
#include "bench/table_file.hpp"

namespace afferent {
namespace {

constexpr std::uint64_t draws = 5;

ForceScore followed(const Touch& touch, DecodingCell cell, double lost, std::uint64_t first_draw,
                    std::uint64_t count) {
    std::vector<FollowedForce> forces;
    cell.lost = lost;
    for (cell.draw = first_draw; cell.draw < first_draw + count; ++cell.draw)
        for (FollowedForce& force : follow(touch, cell)) forces.push_back(std::move(force));
    return score(forces, Touch::step);
}

LossRow measured(const Touch& touch, const std::string& decoder) {
    const DecodingCell cell{"events", decoder, 100us, 5ms};
    const ForceScore lossless = followed(touch, cell, 0, 0, 1);
    const ForceScore lossy = followed(touch, cell, lost_part_of_packets, 1, draws);
    return {touch.name,  touch.elements(),      decoder,           lossless.rms_n,
            lossy.rms_n, *lossless.coverage_95, *lossy.coverage_95};
}

}  // namespace

std::vector<LossRow> measure_loss(const std::vector<Touch>& touches,
                                  const std::function<void(double)>& progress) {
    const std::vector<std::string> decoders{"sliding_window", "exponential", "interval", "inversion",
                                            "filter"};
    std::vector<LossRow> rows(touches.size() * decoders.size());
    std::mutex reporting;
    std::size_t done = 0;
    Workers(std::max(1U, std::thread::hardware_concurrency())).run(rows.size(), [&](std::size_t i) {
        rows[i] = measured(touches[i / decoders.size()], decoders[i % decoders.size()]);
        const std::lock_guard lock(reporting);
        progress(static_cast<double>(++done) / static_cast<double>(rows.size()));
    });
    return rows;
}

void write_loss(const std::vector<LossRow>& rows, const std::filesystem::path& folder) {
    bench::TableFile file(folder / "loss.csv", {"scene", "elements", "decoder", "lost_pct", "lossless_rms_n",
                                                "rms_n", "lossless_coverage_95", "coverage_95"});
    for (const LossRow& row : rows)
        file.row({row.scene, std::to_string(row.elements), row.decoder,
                  bench::number(100 * lost_part_of_packets), bench::number(row.lossless_rms_n),
                  bench::number(row.rms_n), bench::number(row.lossless_coverage_95),
                  bench::number(row.coverage_95)});
    file.close();
}

void print_loss(const std::vector<LossRow>& rows, std::ostream& out) {
    out << "\nWith 10 % of the packets lost: RMS N, times that without loss, and coverage of the 95 % "
           "interval\n"
        << std::setprecision(3);
    for (const LossRow& row : rows)
        out << "  " << std::left << std::setw(26) << row.scene + ", " + std::to_string(row.elements)
            << std::setw(15) << row.decoder << std::right << std::setw(8) << row.rms_n << std::setw(8)
            << row.ratio() << " times" << std::setw(8) << row.coverage_95 << '\n';
}

}  // namespace afferent
