#include "bench/robust_tables.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>

#include "afferent/io/pictures/scatter_picture.hpp"
#include "bench/table_file.hpp"

namespace afferent {
namespace {

bool has_sigma(const RobustRow& row) { return row.decoder != read_by_sensors; }

// "sliding window" for "sliding_window".
std::string spaced(std::string name) {
    std::ranges::replace(name, '_', ' ');
    return name;
}

// The mean over the scenes of a case.
struct Pooled {
    const RobustCase* what;
    std::string decoder;  // ", stated" where it is told of the error
    double rms_n;
    double above_2_sigma;
};

std::vector<Pooled> pooled(const std::vector<RobustRow>& rows) {
    std::vector<Pooled> found;
    std::vector<double> scenes;
    for (const RobustRow& row : rows) {
        const std::string decoder = row.decoder + (row.stated ? ", stated" : "");
        auto of = std::ranges::find_if(
            found, [&](const Pooled& each) { return each.what == row.what && each.decoder == decoder; });
        if (of == found.end()) {
            of = found.insert(of, {row.what, decoder, 0, 0});
            scenes.push_back(0);
        }
        of->rms_n += row.score.rms_n * row.score.rms_n;
        of->above_2_sigma += row.score.above_2_sigma;
        ++scenes[static_cast<std::size_t>(of - found.begin())];
    }
    for (std::size_t i = 0; i < found.size(); ++i) {
        found[i].rms_n = std::sqrt(found[i].rms_n / scenes[i]);
        found[i].above_2_sigma /= scenes[i];
    }
    return found;
}

// In the order of their first appearance.
template <class Key>
auto distinct(const std::vector<Pooled>& cells, Key Pooled::*key) {
    std::vector<Key> found;
    for (const Pooled& each : cells)
        if (std::ranges::find(found, each.*key) == found.end()) found.push_back(each.*key);
    return found;
}

}  // namespace

void write_robustness(const std::vector<RobustRow>& rows, const std::filesystem::path& folder) {
    bench::TableFile file(folder / "robust.csv",
                          {"case", "scene", "decoder", "wrong", "stated", "rms_n", "bias_n", "coverage_95",
                           "above_2_sigma", "left_out", "saturated", "doubtful"});
    for (const RobustRow& row : rows) {
        const RobustScore& score = row.score;
        std::vector<std::string> cells{row.what->name,
                                       row.scene,
                                       row.decoder,
                                       row.what->wrong,
                                       row.stated ? "1" : "0",
                                       bench::number(score.rms_n),
                                       bench::number(score.bias_n)};
        for (const double value :
             {score.coverage_95, score.above_2_sigma, score.left_out, score.saturated, score.doubtful})
            cells.push_back(has_sigma(row) ? bench::number(value) : "");
        file.row(cells);
    }
    file.close();
}

void draw_robustness(const std::vector<RobustRow>& rows, const std::filesystem::path& folder) {
    const std::vector<Pooled> cells = pooled(rows);
    const std::vector<const RobustCase*> cases = distinct(cells, &Pooled::what);
    ScatterPicture picture{.title = "What an estimate is worth where the world is not as told",
                           .x_title = "",
                           .y_title = "RMS error of the force (N)",
                           .series = {}};
    for (const RobustCase* what : cases) picture.x_names.push_back(spaced(what->name));
    for (const std::string& decoder : distinct(cells, &Pooled::decoder)) {
        auto& series = picture.series.emplace_back(
            ScatterPicture::Series{.name = spaced(decoder), .points = {}, .joined = false});
        for (const Pooled& each : cells)
            if (each.decoder == decoder)
                series.points.push_back(
                    {static_cast<double>(std::ranges::find(cases, each.what) - cases.begin() + 1),
                     each.rms_n});
    }
    const Drawing drawing = draw(picture, folder / "robust");
    if (drawing.outcome == Drawn::no_gnuplot) std::cerr << "gnuplot is not installed: no picture\n";
    if (drawing.outcome == Drawn::failed) throw std::runtime_error(drawing.message);
}

void print_robust_cases(const std::vector<RobustRow>& rows, std::ostream& out) {
    const std::vector<Pooled> cells = pooled(rows);
    const std::vector<std::string> decoders = distinct(cells, &Pooled::decoder);
    out << "\nRMS error of the force in N, and the part of the time for which the force is above the "
           "estimate "
           "by more\nthan two sigma; in the mean over the scenes.\n\n| "
        << std::left << std::setw(64) << "what the decoder is not told";
    for (const std::string& decoder : decoders) out << "| " << std::setw(16) << spaced(decoder);
    out << "|\n|---";
    for (std::size_t i = 0; i < decoders.size(); ++i) out << "|---";
    out << "|\n" << std::fixed;
    for (const RobustCase* what : distinct(cells, &Pooled::what)) {
        out << "| " << std::setw(64) << "`" + what->name + "`: " + what->wrong;
        for (const std::string& decoder : decoders) {
            std::ostringstream text;
            text << std::fixed;
            for (const Pooled& each : cells) {
                if (each.what != what || each.decoder != decoder) continue;
                text << std::setprecision(2) << each.rms_n;
                if (decoder != read_by_sensors)
                    text << ", " << std::setprecision(0) << 100 * each.above_2_sigma << " %";
            }
            out << "| " << std::setw(16) << text.str();
        }
        out << "|\n";
    }
    out << std::defaultfloat << std::right;
}

void print_robust_rows(const std::vector<RobustRow>& rows, std::ostream& out) {
    const RobustRow* before = nullptr;
    for (const RobustRow& row : rows) {
        const bool same_case = before && before->what == row.what && before->stated == row.stated;
        if (!before || before->what != row.what)
            out << '\n'
                << std::left << std::setw(44) << row.what->name + ": " + row.what->wrong << std::right << "\n"
                << std::setw(44) << ""
                << "   RMS N    bias  in 95 %  > 2 sd  left out  saturated  doubtful\n";
        const RobustScore& score = row.score;
        out << "  " << std::left << std::setw(26)
            << (same_case && before->scene == row.scene ? "" : row.scene + (row.stated ? ", stated" : ""))
            << std::setw(16) << row.decoder << std::right << std::fixed << std::setprecision(3)
            << std::setw(8) << score.rms_n << std::setw(8) << score.bias_n;
        if (has_sigma(row))
            out << std::setprecision(1) << std::setw(9) << 100 * score.coverage_95 << std::setw(8)
                << 100 * score.above_2_sigma << std::setw(10) << score.left_out << std::setw(11)
                << 100 * score.saturated << std::setw(10) << 100 * score.doubtful;
        out << '\n' << std::defaultfloat;
        before = &row;
    }
}

}  // namespace afferent
