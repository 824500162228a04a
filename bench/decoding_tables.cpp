#include "bench/decoding_tables.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "afferent/io/pictures/scatter_picture.hpp"
#include "bench/table_file.hpp"
#include "bench/wander_limits.hpp"

namespace afferent {
namespace {

// Five digits: more than the scenes of a benchmark are alike.
std::string digits(double value) {
    std::ostringstream text;
    text << std::setprecision(5) << value;
    return text.str();
}

bool is_events(const DecodingRow& row) { return row.cell.tick.has_value(); }

// What a person reads: the default link, and of the alternatives what is sent as often.
bool shown(const DecodingRow& row) {
    const DecodingCell& cell = row.cell;
    if (is_events(row)) return *cell.tick == Duration(100us) && cell.deadline == Duration(5ms);
    if (cell.decoder == "hold") return false;
    const Duration interval = cell.every_scan * row.touch->activity.frame_interval;
    return cell.delta ? cell.deadline == Duration(5ms) : cell.deadline == interval;
}

// The curve to which it belongs.
std::string curve_of(const DecodingRow& row) {
    if (is_events(row)) {
        std::string decoder = row.cell.decoder;
        std::replace(decoder.begin(), decoder.end(), '_', ' ');
        return (row.cell.tolerance ? "predicted events, " : "events, ") + decoder;
    }
    if (row.cell.scheme == "raw12") return "12-bit samples";
    if (row.cell.scheme == "delta_varint") return "differences of samples";
    if (row.cell.scheme == "delta_coded") return "differences, range-coded";
    if (row.cell.scheme == "linear_prediction") return "send-on-delta from a line";
    if (row.cell.scheme == "dead_band") return "relative dead band";
    return "send-on-delta";
}

// Only what no other setting of the same scheme beats in both bytes and error.
std::vector<const DecodingRow*> best_of(std::vector<const DecodingRow*> rows) {
    std::sort(rows.begin(), rows.end(), [](const DecodingRow* one, const DecodingRow* other) {
        return std::pair(one->bytes_per_s, one->score.rms_n) <
               std::pair(other->bytes_per_s, other->score.rms_n);
    });
    std::vector<const DecodingRow*> best;
    for (const DecodingRow* row : rows)
        if (best.empty() || row->score.rms_n < best.back()->score.rms_n) best.push_back(row);
    return best;
}

struct Limit {
    const char* name;
    std::function<double(double bytes_per_s)> rms_n;
};

// By the bytes for each force that is touched. An event counts with the bytes that the scene's own take.
std::vector<Limit> limits_of(const Touch& touch, double bytes_per_event) {
    const WanderLimits limits{touch.wander_n2_per_s()};
    return {
        {"limit: free timing", [=](double b) { return std::sqrt(limits.event_triggered(8 * b)); }},
        {"limit: uniform samples", [=](double b) { return std::sqrt(limits.uniform(8 * b)); }},
        {"limit: bits alone, packets of 5 ms",
         [=](double b) { return std::sqrt(limits.aged(limits.causal(8 * b), 0.005, seconds(delivery))); }},
        {"average of intervals, no adaptation",
         [=](double b) { return std::sqrt(limits.integrate_and_fire(b / bytes_per_event)); }},
    };
}

void draw_touch(const std::vector<const DecodingRow*>& rows, const std::filesystem::path& folder) {
    const Touch& touch = *rows.front()->touch;
    ScatterPicture picture{.title = "What a byte buys: " + touch.name + ", " +
                                    std::to_string(touch.elements()) +
                                    (touch.elements() == 1 ? " element" : " elements"),
                           .x_title = "bytes per second",
                           .y_title = "RMS error of the force (N)",
                           .series = {}};
    std::vector<std::pair<std::string, std::vector<const DecodingRow*>>> curves;
    double least_bytes = rows.front()->bytes_per_s;
    double most_bytes = least_bytes;
    double event_bytes_per_s = 0;
    for (const DecodingRow* row : rows) {
        least_bytes = std::min(least_bytes, row->bytes_per_s);
        most_bytes = std::max(most_bytes, row->bytes_per_s);
        if (row->cell.scheme == "events" && shown(*row)) event_bytes_per_s = row->bytes_per_s;
        if (row->cell.decoder == "hold") continue;
        const std::string name = curve_of(*row);
        auto curve =
            std::find_if(curves.begin(), curves.end(), [&](const auto& each) { return each.first == name; });
        if (curve == curves.end()) curve = curves.insert(curves.end(), {name, {}});
        curve->second.push_back(row);
    }
    for (const auto& [name, all] : curves) {
        auto& series = picture.series.emplace_back(ScatterPicture::Series{.name = name, .points = {}});
        for (const DecodingRow* row : best_of(all))
            series.points.push_back({row->bytes_per_s, row->score.rms_n});
    }
    const double events_per_s =
        static_cast<double>(touch.activity.events.size()) / touch.activity.seconds_long();
    for (const Limit& limit : limits_of(touch, event_bytes_per_s / std::max(1.0, events_per_s))) {
        auto& series = picture.series.emplace_back(
            ScatterPicture::Series{.name = limit.name, .points = {}, .marked = false});
        for (const double bytes : {least_bytes, std::sqrt(least_bytes * most_bytes), most_bytes})
            series.points.push_back({bytes, limit.rms_n(bytes / static_cast<double>(touch.touched()))});
    }
    const Drawing drawing =
        draw(picture, folder / ("decoding-" + touch.name + "-" + std::to_string(touch.elements())));
    if (drawing.outcome == Drawn::no_gnuplot) std::cerr << "gnuplot is not installed: no picture\n";
    if (drawing.outcome == Drawn::failed) throw std::runtime_error(drawing.message);
}

// Calls visit(rows) for each touch.
template <class Visit>
void for_each_touch(const std::vector<DecodingRow>& rows, Visit&& visit) {
    std::vector<const DecodingRow*> of_touch;
    for (const DecodingRow& row : rows) {
        if (!of_touch.empty() && of_touch.back()->touch != row.touch) {
            visit(std::as_const(of_touch));
            of_touch.clear();
        }
        of_touch.push_back(&row);
    }
    if (!of_touch.empty()) visit(std::as_const(of_touch));
}

}  // namespace

std::string name_of(const DecodingRow& row) {
    const DecodingCell& cell = row.cell;
    if (cell.tolerance)
        return cell.scheme + ", within " + digits(Milliseconds(*cell.tolerance).count()) + " ms";
    if (is_events(row)) return cell.scheme + ", " + cell.decoder;
    if (cell.dead_band)
        return cell.scheme + " " + digits(100 * *cell.dead_band) + " %" +
               (*cell.delta > 0 ? ", least " + digits(100 * *cell.delta) : "");
    if (cell.delta) return cell.scheme + " " + digits(100 * *cell.delta) + " %";
    const Duration interval = cell.every_scan * row.touch->activity.frame_interval;
    return cell.scheme + " " + digits(1 / seconds(interval)) + " Hz";
}

void write_decoding(const std::vector<DecodingRow>& rows, const std::filesystem::path& folder) {
    bench::TableFile file(folder / "decoding.csv",
                          {"scene", "elements", "scheme", "decoder", "tick_us", "deadline_ms", "bytes_per_s",
                           "rms_n", "rms_sensed_n", "p95_n", "hold_bias_n", "overshoot_n", "delay_ms",
                           "coverage_95", "delta", "dead_band", "tolerance_us"});
    for (const DecodingRow& row : rows) {
        const DecodingCell& cell = row.cell;
        const ForceScore& score = row.score;
        file.row({row.touch->name, std::to_string(row.touch->elements()), cell.scheme, cell.decoder,
                  cell.tick ? digits(static_cast<double>(cell.tick->count()) / 1e3) : "",
                  digits(Milliseconds(cell.deadline).count()), digits(row.bytes_per_s), digits(score.rms_n),
                  digits(score.rms_sensed_n), digits(score.p95_n), digits(score.hold_bias_n),
                  digits(score.overshoot_n), digits(score.delay_ms),
                  score.coverage_95 ? digits(*score.coverage_95) : "", cell.delta ? digits(*cell.delta) : "",
                  cell.dead_band ? digits(*cell.dead_band) : "",
                  cell.tolerance ? digits(static_cast<double>(cell.tolerance->count()) / 1e3) : ""});
    }
    file.close();
}

void draw_decoding(const std::vector<DecodingRow>& rows, const std::filesystem::path& folder) {
    for_each_touch(rows, [&](const auto& of_touch) { draw_touch(of_touch, folder); });
}

void print_decoding(const std::vector<DecodingRow>& rows, std::ostream& out) {
    for_each_touch(rows, [&](const auto& of_touch) {
        const Touch& touch = *of_touch.front()->touch;
        out << '\n'
            << touch.name << ", " << touch.elements() << " elements, "
            << digits(static_cast<double>(touch.activity.events.size()) / touch.activity.seconds_long())
            << " events/s; the force wanders by " << digits(touch.wander_n2_per_s()) << " N^2/s\n"
            << std::left << std::setw(28) << "  packets of 5 ms" << std::right;
        for (const char* const column :
             {"bytes/s", "RMS N", "sensed", "95 %", "bias", "overshoot", "delay ms", "inside %", "x limit"})
            out << std::setw(10) << column;
        out << '\n' << std::setprecision(3);
        for (const DecodingRow* row : of_touch) {
            if (!shown(*row)) continue;
            const ForceScore& score = row->score;
            out << "  " << std::left << std::setw(26) << name_of(*row) << std::right << std::setw(10)
                << std::llround(row->bytes_per_s);
            for (const double value :
                 {score.rms_n, score.rms_sensed_n, score.p95_n, score.hold_bias_n, score.overshoot_n,
                  score.delay_ms, 100 * score.coverage_95.value_or(0), row->times_the_limit})
                out << std::setw(10) << value;
            out << '\n';
        }
    });
    out << "\nEvery row is of packets that are delivered 2 ms after they close. Samples are decoded by the "
           "filter's own force model.\n\"x limit\" is the RMS error over the least that a causal code of as "
           "many bits can have of a force that wanders\nas much from scan to scan, in packets of that span. "
           "A force that is smoother than that can be known better.\n";
}

}  // namespace afferent
