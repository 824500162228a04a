// afferent bench bandwidth: what must a link carry? Bytes per second for events and for every honest
// alternative, in the same frames, with the time that coding takes; and the latency of packets.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <memory>
#include <sstream>

#include "afferent/apps/bench_commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/io/files/table.hpp"
#include "afferent/io/pictures/scatter_picture.hpp"
#include "afferent/io/wire/packet_layout.hpp"
#include "afferent/scene/scene.hpp"
#include "bench/link_schemes.hpp"
#include "bench/transport_bench.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

struct Options {
    std::string scene = "examples/grasp.txtpb";
    std::string out;
    std::vector<std::string> tables;
    std::vector<std::uint32_t> elements{9, 1000, 100'000};
    bool quick = false;
    bool json = false;
};

constexpr double poisson_hz = 20;

struct Row {
    const LinkActivity* activity;
    SchemeResult result;

    double bytes_per_s() const { return static_cast<double>(result.bytes) / activity->seconds_long(); }
};

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

std::vector<SchemeResult> measure(const LinkActivity& activity) {
    std::vector<SchemeResult> results;
    const auto poisson = activity.name == "poisson20" ? std::optional(poisson_hz) : std::nullopt;
    for (const Duration tick : {Duration(1us), Duration(100us), Duration(1ms)})
        for (const Duration deadline : {Duration(1ms), Duration(5ms), Duration(10ms), Duration(20ms)}) {
            const PacketLayout layout{.addresses = activity.elements, .tick = tick, .span = deadline};
            if (layout.keys() <= std::uint64_t{1} << 32)
                results.push_back(measure_events(activity, tick, deadline, poisson));
        }
    results.push_back(measure_repeated_messages(activity, 100us, 5ms));
    results.push_back(measure_packed_columns(activity, 100us, 5ms));
    if (activity.counts.empty()) return results;
    results.push_back(measure_raw(activity, 12));
    results.push_back(measure_raw(activity, 16));
    results.push_back(measure_delta_varint(activity));
    // Deltas as shares of one element's full scale, which is a share of the grip force.
    for (const double of_scale : {0.002, 0.01, 0.05})
        results.push_back(measure_send_on_delta(activity, of_scale * 4095 * activity.newtons_per_count));
    return results;
}

GripForce force_of(const Table& table) {
    return [&table](TimePoint time) {
        const auto after = std::upper_bound(table.times.begin(), table.times.end(), time);
        if (after == table.times.begin()) return 0.0;
        return std::max(0.0, table.row(static_cast<std::size_t>(after - table.times.begin()) - 1)[0]);
    };
}

std::vector<LinkActivity> activities(const Options& options) {
    const Scene scene = Scene::from_file(options.scene);
    const GripForce grasp = grip_force_of(scene);
    std::vector<LinkActivity> found;
    for (const std::uint32_t elements : options.elements) {
        std::cerr << elements << " elements\n";
        const Duration duration = scene.duration();
        found.push_back(grip_activity(scene, elements, "rest", std::min<Duration>(duration, 2s),
                                      [](TimePoint) { return 0; }));
        found.push_back(poisson_activity(elements, poisson_hz,
                                         elements < 100      ? 100s
                                         : elements < 10'000 ? 10s
                                                             : 1s,
                                         1));
        found.push_back(grip_activity(scene, elements, "grasp", duration, grasp));
    }
    for (const std::string& file : options.tables) {
        auto read = read_table(file);
        if (const auto* error = std::get_if<TableError>(&read)) throw Failure(error->message());
        const Table& table = std::get<Table>(read);
        found.push_back(grip_activity(scene, scene.elements(), fs::path(file).stem().string(),
                                      table.times.back() - scene_start, force_of(table)));
    }
    return found;
}

void write_tables(const fs::path& folder, const std::vector<Row>& rows,
                  const std::vector<TransportResult>& transports) {
    std::ofstream bandwidth(folder / "bandwidth.csv");
    bandwidth
        << "elements,activity,scheme,tick_us,deadline_ms,events,bytes_per_s,bytes_per_event,entropy_ratio,"
           "encode_ns,decode_ns,delta_n\n";
    for (const Row& row : rows) {
        const auto& [activity, result] = row;
        const auto events = static_cast<double>(activity->events.size());
        bandwidth << activity->elements << ',' << activity->name << ',' << result.scheme << ','
                  << (result.tick ? number(static_cast<double>(result.tick->count()) / 1e3) : "") << ','
                  << cell(result.deadline) << ',' << activity->events.size() << ','
                  << number(row.bytes_per_s()) << ','
                  << (events > 0 ? number(static_cast<double>(result.bytes) / events) : "") << ','
                  << cell(result.entropy_ratio) << ',' << cell(result.encode_ns) << ','
                  << cell(result.decode_ns) << ',' << cell(result.delta_n) << '\n';
    }
    std::ofstream transport(folder / "transport.csv");
    transport << "transport,packet_ms,events_per_s,p50_us,p99_us\n";
    for (const TransportResult& row : transports)
        transport << row.transport << ',' << cell(std::optional(row.packet)) << ','
                  << number(row.events_per_s) << ',' << number(row.p50_us) << ',' << number(row.p99_us)
                  << '\n';
    bandwidth.close();
    transport.close();
    if (!bandwidth || !transport) throw Failure(folder.string() + ": the tables cannot be written");
}

// The rows that a person reads first: the default link and each alternative.
bool shown(const SchemeResult& result) {
    return result.scheme != "events" || (result.tick == Duration(100us) && result.deadline == Duration(5ms));
}

void draw_picture(const fs::path& folder, const std::vector<Row>& rows) {
    ScatterPicture picture{.title = "What a link carries in a grasp",
                           .x_title = "elements",
                           .y_title = "bytes per second",
                           .series = {}};
    for (const Row& row : rows) {
        if (row.activity->name != "grasp" || !shown(row.result)) continue;
        std::string name = row.result.scheme;
        // As a percentage of full scale, which is the same for every number of elements.
        if (row.result.delta_n)
            name +=
                setting(std::round(*row.result.delta_n / row.activity->newtons_per_count / 4.095) / 10, "%");
        auto series = std::find_if(picture.series.begin(), picture.series.end(),
                                   [&](const auto& s) { return s.name == name; });
        if (series == picture.series.end())
            series = picture.series.insert(series, {.name = name, .points = {}});
        series->points.push_back({static_cast<double>(row.activity->elements), row.bytes_per_s(), ""});
    }
    const Drawing drawing = draw(picture, folder / "bandwidth");
    if (drawing.outcome == Drawn::no_gnuplot) std::cerr << "gnuplot is not installed: no picture\n";
    if (drawing.outcome == Drawn::failed) throw Failure(drawing.message);
}

// The default link, which the others are compared with.
bool is_default(const SchemeResult& result) { return result.scheme == "events" && shown(result); }

void print_table(const std::vector<Row>& rows, const std::vector<TransportResult>& transports) {
    const LinkActivity* activity = nullptr;
    double events_bytes = 0;
    std::cout << std::setprecision(4);
    for (const Row& row : rows) {
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
        if (row.result.delta_n) name += setting(*row.result.delta_n, "N");
        std::cout << "  " << std::left << std::setw(28) << name << std::right << std::setw(12)
                  << row.bytes_per_s() / 1e3 << " kB/s";
        if (is_default(row.result)) events_bytes = row.bytes_per_s();
        std::cout << (row.bytes_per_s() < events_bytes ? "  events lose" : "             ");
        if (row.result.entropy_ratio) std::cout << "   " << *row.result.entropy_ratio << " of the entropy";
        if (row.result.encode_ns)
            std::cout << "   " << *row.result.encode_ns << " ns in, " << *row.result.decode_ns << " ns out";
        std::cout << '\n';
    }
    std::cout << "\nPackets of 100,000 addresses at 20 Hz; on the serial line, of 921,600 baud, of 1,000\n";
    for (const TransportResult& row : transports)
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

Summary summarise(const std::vector<Row>& rows, const std::vector<TransportResult>& transports) {
    Summary summary;
    for (const Row& row : rows) {
        Summary entry;
        entry["elements"] = row.activity->elements;
        entry["activity"] = row.activity->name;
        entry["scheme"] = row.result.scheme;
        if (row.result.tick) entry["tick_us"] = static_cast<double>(row.result.tick->count()) / 1e3;
        if (row.result.deadline) entry["deadline_ms"] = Milliseconds(*row.result.deadline).count();
        if (row.result.delta_n) entry["delta_n"] = *row.result.delta_n;
        entry["events"] = row.activity->events.size();
        entry["bytes_per_s"] = row.bytes_per_s();
        if (row.result.entropy_ratio) entry["entropy_ratio"] = *row.result.entropy_ratio;
        if (row.result.encode_ns) entry["encode_ns"] = *row.result.encode_ns;
        if (row.result.decode_ns) entry["decode_ns"] = *row.result.decode_ns;
        summary["bandwidth"].push_back(entry);
    }
    for (const TransportResult& row : transports)
        summary["transport"].push_back({{"transport", row.transport},
                                        {"packet_ms", Milliseconds(row.packet).count()},
                                        {"events_per_s", row.events_per_s},
                                        {"p50_us", row.p50_us},
                                        {"p99_us", row.p99_us}});
    return summary;
}

void bench_bandwidth(const Options& options) {
    if (!options.out.empty()) fs::create_directories(options.out);
    const std::vector<LinkActivity> all = activities(options);
    std::vector<Row> rows;
    std::vector<TransportResult> transports;
    {
        Progress progress("bench bandwidth");
        for (const LinkActivity& activity : all) {
            progress.at(static_cast<double>(&activity - all.data()) / static_cast<double>(all.size() + 1));
            for (SchemeResult& result : measure(activity)) rows.push_back({&activity, std::move(result)});
        }
        transports = measure_transports({1ms, 5ms, 20ms});
    }
    if (!options.out.empty()) {
        write_tables(options.out, rows, transports);
        draw_picture(options.out, rows);
    }
    if (options.json)
        print(summarise(rows, transports), true);
    else
        print_table(rows, transports);
}

}  // namespace

Command bench_bandwidth_command() {
    const auto options = std::make_shared<Options>();
    return {
        .name = "bandwidth",
        .help = "What a link must carry, for events and every alternative",
        .footer = "Example:\n  afferent bench bandwidth examples/grasp.txtpb --out out/bandwidth",
        .options =
            {
                positional("scene", options->scene, "Scene whose sensors, neurons and grasp are measured")
                    .show_default(),
                option("--out", options->out,
                       "Folder for bandwidth.csv, transport.csv, bandwidth.svg and .png"),
                option("--table", options->tables,
                       "Recorded grip forces in newtons, measured as further activities"),
                option("--elements", options->elements, "How many elements").show_default(),
                flag("--quick", options->quick, "Nine elements alone"),
                flag("--json", options->json, "Print the results as JSON"),
            },
        .run =
            [options] {
                if (options->quick) options->elements = {9};
                bench_bandwidth(*options);
            },
    };
}

}  // namespace afferent
