#include "bench/bandwidth_tables.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "afferent/io/pictures/scatter_picture.hpp"

namespace afferent {
namespace {

std::string number(double value) {
    std::ostringstream text;
    text << std::setprecision(6) << value;
    return text.str();
}

// What follows the name of a scheme.
std::string setting(double value, const char* unit) {
    std::ostringstream text;
    text << ' ' << std::setprecision(6) << value << ' ' << unit;
    return text.str();
}

template <class Value>
std::string cell(const std::optional<Value>& value) {
    if (!value) return "";
    if constexpr (std::is_same_v<Value, Duration>)
        return number(Milliseconds(*value).count());
    else
        return number(*value);
}

// The rows that a person reads first: the default link and each alternative.
bool shown(const SchemeResult& result) {
    return result.scheme != "events" || (result.tick == Duration(100us) && result.deadline == Duration(5ms));
}

// A scheme as a legend names it.
std::string in_words(const std::string& scheme) {
    if (scheme == "raw12") return "12-bit samples";
    if (scheme == "raw16") return "16-bit samples";
    if (scheme == "delta_varint") return "differences of samples";
    if (scheme == "delta_coded") return "differences, range-coded";
    if (scheme == "send_on_delta") return "send-on-delta of";
    if (scheme == "linear_prediction") return "send-on-delta from a line, of";
    if (scheme == "dead_band") return "dead band of";
    if (scheme == "predicted") return "events, predicted, within";
    if (scheme == "repeated_messages") return "events, a message each";
    if (scheme == "packed_columns") return "events in packed columns";
    return scheme;
}

// The place of a scheme among those seen so far.
std::size_t kind_of(const std::string& scheme, std::vector<std::string>& kinds) {
    const auto found = std::find(kinds.begin(), kinds.end(), scheme);
    if (found == kinds.end()) kinds.push_back(scheme);
    return static_cast<std::size_t>(std::find(kinds.begin(), kinds.end(), scheme) - kinds.begin());
}

// The default link, which the others are compared with.
bool is_default(const SchemeResult& result) { return result.scheme == "events" && shown(result); }

}  // namespace

void write_bandwidth(const Bandwidth& bandwidth, const std::filesystem::path& folder) {
    std::ofstream schemes(folder / "bandwidth.csv");
    schemes
        << "elements,activity,scheme,tick_us,deadline_ms,events,bytes_per_s,bytes_per_event,poisson_ratio,"
           "encode_ns,decode_ns,delta_n,tolerance_us,rms_n,dead_band,causal_bits_per_event,"
           "poisson_bits_per_event\n";
    for (const BandwidthRow& row : bandwidth.rows) {
        const auto& [activity, result] = row;
        const auto events = static_cast<double>(activity->events.size());
        schemes << activity->elements << ',' << activity->name << ',' << result.scheme << ','
                << (result.tick ? number(static_cast<double>(result.tick->count()) / 1e3) : "") << ','
                << cell(result.deadline) << ',' << activity->events.size() << ',' << number(row.bytes_per_s())
                << ',' << (events > 0 ? number(static_cast<double>(result.bytes) / events) : "") << ','
                << cell(result.poisson_ratio) << ',' << cell(result.encode_ns) << ','
                << cell(result.decode_ns) << ',' << cell(result.delta_n) << ','
                << (result.tolerance ? number(static_cast<double>(result.tolerance->count()) / 1e3) : "")
                << ',' << cell(result.rms_n) << ',' << cell(result.dead_band) << ','
                << cell(result.causal_bits) << ',' << cell(result.poisson_bits) << '\n';
    }
    std::ofstream transports(folder / "transport.csv");
    transports << "transport,packet_ms,events_per_s,p50_us,p99_us\n";
    for (const TransportResult& row : bandwidth.transports)
        transports << row.transport << ',' << cell(std::optional(row.packet)) << ','
                   << number(row.events_per_s) << ',' << number(row.p50_us) << ',' << number(row.p99_us)
                   << '\n';
    schemes.close();
    transports.close();
    if (!schemes || !transports) throw std::runtime_error(folder.string() + ": the tables cannot be written");
}

void draw_bandwidth(const Bandwidth& bandwidth, const std::filesystem::path& folder) {
    ScatterPicture picture{.title = "What a link carries while something is held",
                           .x_title = "elements",
                           .y_title = "bytes per second",
                           .series = {}};
    std::vector<std::string> kinds;
    for (const BandwidthRow& row : bandwidth.rows) {
        if ((row.activity->name != "grasp" && row.activity->name != "recording") || !shown(row.result))
            continue;
        std::string name = in_words(row.result.scheme);
        // As a percentage of full scale, which is the same for every number of elements.
        if (row.result.dead_band)
            name += setting(100 * *row.result.dead_band, "%");
        else if (row.result.delta_n)
            name +=
                setting(std::round(*row.result.delta_n / row.activity->newtons_per_count / 4.095) / 10, "%");
        if (row.result.tolerance)
            name += setting(static_cast<double>(row.result.tolerance->count()) / 1e6, "ms");
        auto series = std::find_if(picture.series.begin(), picture.series.end(),
                                   [&](const auto& s) { return s.name == name; });
        if (series == picture.series.end())
            series = picture.series.insert(
                series, {.name = name, .points = {}, .kind = kind_of(row.result.scheme, kinds)});
        series->points.push_back({static_cast<double>(row.activity->elements), row.bytes_per_s()});
    }
    const Drawing drawing = draw(picture, folder / "bandwidth");
    if (drawing.outcome == Drawn::no_gnuplot) std::cerr << "gnuplot is not installed: no picture\n";
    if (drawing.outcome == Drawn::failed) throw std::runtime_error(drawing.message);
}

void print_bandwidth(const Bandwidth& bandwidth) {
    const LinkActivity* activity = nullptr;
    double events_bytes = 0;
    std::cout << std::setprecision(4);
    for (const BandwidthRow& row : bandwidth.rows) {
        if (!shown(row.result)) continue;
        if (row.activity != activity) {
            activity = row.activity;
            events_bytes = 0;
            std::cout << '\n'
                      << activity->elements << " elements, " << activity->name << ": "
                      << static_cast<double>(activity->events.size()) / activity->seconds_long()
                      << " events/s\n";
        }
        std::string name = row.result.scheme;
        if (row.result.dead_band) name += setting(100 * *row.result.dead_band, "%, least");
        if (row.result.delta_n) name += setting(*row.result.delta_n, "N");
        if (row.result.tolerance)
            name += setting(static_cast<double>(row.result.tolerance->count()) / 1e6, "ms");
        std::cout << "  " << std::left << std::setw(28) << name << std::right << std::setw(12)
                  << row.bytes_per_s() / 1e3 << " kB/s";
        if (is_default(row.result)) events_bytes = row.bytes_per_s();
        const bool samples = row.result.scheme != "predicted";
        std::cout << (samples && row.bytes_per_s() < events_bytes ? "  events lose" : "             ");
        if (row.result.rms_n) std::cout << "   " << *row.result.rms_n << " N RMS";
        if (row.result.poisson_ratio)
            std::cout << "   " << *row.result.poisson_ratio << " of the Poisson entropy";
        if (row.result.causal_bits)
            std::cout << "   causal entropy at most " << *row.result.causal_bits << " bits an event, Poisson "
                      << *row.result.poisson_bits;
        if (row.result.encode_ns)
            std::cout << "   " << *row.result.encode_ns << " ns in, " << *row.result.decode_ns << " ns out";
        std::cout << '\n';
    }
    std::cout << "\nPackets of 100,000 addresses at 20 Hz; on the serial line, of 921,600 baud, of 1,000\n";
    for (const TransportResult& row : bandwidth.transports)
        std::cout << "  " << std::left << std::setw(12) << row.transport << std::right << std::setw(6)
                  << Milliseconds(row.packet).count() << " ms" << std::setw(12) << row.events_per_s / 1e6
                  << " million events/s" << std::setw(10) << row.p50_us << " us median" << std::setw(10)
                  << row.p99_us << " us p99\n";
    // An event costs about log2(e / (rate · tick)) bits, and a sample 12.
    std::cout << "\nWhere events lose: one address costs rate · log2(e / (rate · tick)) bits/s as events and "
                 "2400 as 12-bit\n"
                 "samples at 200 Hz. At a tick of 100 us they are equal at about 390 Hz. Against "
                 "send-on-delta they lose wherever the\n"
                 "force is steady and nobody needs the spikes: a neuron goes on firing under a force that "
                 "does not change.\n";
}

}  // namespace afferent
