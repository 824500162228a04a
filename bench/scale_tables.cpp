#include "bench/scale_tables.hpp"

#include <algorithm>
#include <iomanip>
#include <iostream>
#include <optional>
#include <stdexcept>

#include "afferent/io/pictures/scatter_picture.hpp"
#include "bench/table_file.hpp"

namespace afferent::bench {
namespace {

using scene::Form;

constexpr std::array forms{Form::sparse, Form::dense, Form::automatic};

std::string known(const std::optional<double>& value) { return value ? number(*value) : ""; }

std::string threads_text(std::uint32_t threads) {
    return std::to_string(threads) + (threads == 1 ? " thread" : " threads");
}

// 10'000 as "10,000".
std::string grouped(std::uint32_t value) {
    std::string text = std::to_string(value);
    for (std::size_t at = text.size(); at > 3; at -= 3) text.insert(at - 3, 1, ',');
    return text;
}

std::vector<const ScaleRow*> rows_where(const ScaleReport& report, const auto& holds) {
    std::vector<const ScaleRow*> found;
    for (const ScaleRow& row : report.rows)
        if (holds(row)) found.push_back(&row);
    return found;
}

bool is_block(const ScaleRow& row) { return row.run.population.contact == Contact::block; }

std::uint32_t largest(const ScaleReport& report) {
    return std::ranges::max_element(report.rows, {},
                                    [](const ScaleRow& row) { return row.run.population.elements; })
        ->run.population.elements;
}

std::uint32_t most_threads(const ScaleReport& report) {
    return std::ranges::max_element(report.rows, {}, [](const ScaleRow& row) { return row.run.threads; })
        ->run.threads;
}

// What an element would take if the whole population were read and written once a frame, and nothing else.
double memory_ns(const ScaleReport& report, const ScaleRow& row) {
    const auto at = std::ranges::find(report.bandwidth, row.run.threads, &MemoryBandwidth::threads);
    return at == report.bandwidth.end() ? 0 : 1e9 * 2 * row.bytes_per_element() / at->bytes_per_s;
}

void show(const ScatterPicture& picture, const std::filesystem::path& stem) {
    const Drawing drawing = draw(picture, stem);
    if (drawing.outcome == Drawn::no_gnuplot) std::cerr << "gnuplot is not installed: no picture\n";
    if (drawing.outcome == Drawn::failed) throw std::runtime_error(drawing.message);
}

void draw_by_elements(const ScaleReport& report, const std::filesystem::path& folder) {
    ScatterPicture picture{"Cost of an element by the size of the population",
                           "elements",
                           "ns per element and frame of 5 ms",
                           {}};
    const std::uint32_t most = most_threads(report);
    for (std::size_t kind = 0; kind < forms.size(); ++kind)
        for (const double fraction : {1.0, 0.01})
            for (const std::uint32_t threads : {1U, most}) {
                if (threads > 1 && (most == 1 || fraction < 1)) continue;
                ScatterPicture::Series series{.name = name(forms[kind]) +
                                                      (fraction < 1 ? ", 1 % touched" : ", all touched") +
                                                      (threads > 1 ? ", " + threads_text(threads) : ""),
                                              .points = {},
                                              .kind = kind};
                for (const ScaleRow* row : rows_where(report, [&](const ScaleRow& each) {
                         return is_block(each) && each.run.form == forms[kind] &&
                                each.run.threads == threads &&
                                each.run.population.active_fraction == fraction;
                     }))
                    series.points.push_back({static_cast<double>(row->run.population.elements), row->ns()});
                if (!series.points.empty()) picture.series.push_back(series);
            }
    for (const std::uint32_t threads : most > 1 ? std::vector{1U, most} : std::vector{1U}) {
        const auto dense = rows_where(report, [&](const ScaleRow& each) {
            return is_block(each) && each.run.form == Form::dense && each.run.threads == threads &&
                   each.run.population.active_fraction == 1;
        });
        if (dense.empty()) continue;
        // What the largest one holds for an element: the smallest hold more, and are in the cache.
        const double ns = memory_ns(report, *dense.back());
        picture.series.push_back(
            {.name = "memory: dense form read and written, " + threads_text(threads),
             .points = {{static_cast<double>(report.rows.front().run.population.elements), ns},
                        {static_cast<double>(largest(report)), ns}},
             .marked = false});
    }
    show(picture, folder / "scale_elements");
}

void draw_by_activity(const ScaleReport& report, const std::filesystem::path& folder) {
    const std::uint32_t elements = largest(report);
    ScatterPicture picture{"Cost by how much is touched: " + grouped(elements) + " elements, 1 thread",
                           "touched, % of the elements",
                           "ns per element and frame of 5 ms",
                           {}};
    for (std::size_t kind = 0; kind < forms.size(); ++kind)
        for (const Contact contact : {Contact::block, Contact::scattered}) {
            ScatterPicture::Series series{
                .name = name(forms[kind]) + (contact == Contact::scattered ? ", scattered" : ""),
                .points = {},
                .kind = kind};
            for (const ScaleRow* row : rows_where(report, [&](const ScaleRow& each) {
                     return each.run.form == forms[kind] && each.run.threads == 1 &&
                            each.run.population.elements == elements &&
                            each.run.population.contact == contact;
                 }))
                series.points.push_back({100 * row->run.population.active_fraction, row->ns()});
            if (!series.points.empty()) picture.series.push_back(series);
        }
    const auto dense = rows_where(report, [&](const ScaleRow& each) {
        return is_block(each) && each.run.form == Form::dense && each.run.threads == 1 &&
               each.run.population.elements == elements;
    });
    ScatterPicture::Series line{.name = "memory: dense form read and written", .points = {}, .marked = false};
    for (const ScaleRow* row : dense)
        line.points.push_back({100 * row->run.population.active_fraction, memory_ns(report, *row)});
    picture.series.push_back(line);
    show(picture, folder / "scale_activity");
}

void draw_by_threads(const ScaleReport& report, const std::filesystem::path& folder) {
    ScatterPicture picture{"Real-time factor by threads or ranks, all touched",
                           "threads or ranks",
                           "scene time over run time",
                           {}};
    std::vector<std::uint32_t> sizes;
    for (const ScaleRow& row : report.rows)
        if (row.run.threads > 1 && (sizes.empty() || sizes.back() != row.run.population.elements))
            sizes.push_back(row.run.population.elements);
    for (std::size_t kind = 0; kind < sizes.size(); ++kind)
        for (const Form form : {Form::dense, Form::sparse}) {
            ScatterPicture::Series series{
                .name = grouped(sizes[kind]) + ", " + name(form), .points = {}, .kind = kind};
            for (const ScaleRow* row : rows_where(report, [&](const ScaleRow& each) {
                     return is_block(each) && each.run.form == form &&
                            each.run.population.elements == sizes[kind] &&
                            each.run.population.active_fraction == 1;
                 }))
                series.points.push_back({static_cast<double>(row->run.threads), row->cost.realtime_factor()});
            picture.series.push_back(series);
        }
    ScatterPicture::Series ranks{.name = "", .points = {}, .kind = sizes.size()};
    for (const ScaleRow& row : report.ranks.rows) {
        ranks.name = grouped(row.run.population.elements) + ", afferent run, ranks";
        ranks.points.push_back({static_cast<double>(row.ranks), row.cost.realtime_factor()});
    }
    if (ranks.points.size() > 1) picture.series.push_back(ranks);
    // On one processor there is nothing to compare.
    if (!picture.series.empty()) show(picture, folder / "scale_threads");
}

void print_rows(const ScaleReport& report, std::ostream& out) {
    out << "\nns per element and frame of 5 ms (least to most of the repeats), all events checked\n"
        << std::setw(10) << "elements" << std::setw(9) << "touched" << std::setw(11) << "" << std::setw(9)
        << "threads";
    for (const Form form : forms) out << std::setw(31) << name(form);
    out << std::setw(12) << "real time" << std::setw(12) << "events/s\n";
    out << std::setprecision(3);
    for (std::size_t i = 0; i < report.rows.size(); ++i) {
        const ScaleRow& row = report.rows[i];
        if (row.run.form != forms.front()) continue;
        const ScalePopulation& population = row.run.population;
        out << std::setw(10) << grouped(population.elements) << std::setw(7)
            << 100 * population.active_fraction << " %" << std::setw(11) << name(population.contact)
            << std::setw(9) << row.run.threads;
        const ScaleRow* best = &row;
        for (const Form form : forms) {
            const ScaleRow& each = *std::find_if(report.rows.begin() + static_cast<std::ptrdiff_t>(i),
                                                 report.rows.end(), [&](const ScaleRow& other) {
                                                     return other.run.form == form &&
                                                            other.run.threads == row.run.threads &&
                                                            other.run.population == population;
                                                 });
            const double ns_per_s = 1e9 / population.elements;
            std::ostringstream cell;
            cell << std::setprecision(3) << each.ns() << " (" << each.cost.least_s * ns_per_s << " to "
                 << each.cost.most_s * ns_per_s << ')';
            out << std::setw(31) << cell.str();
            if (each.cost.frame_s < best->cost.frame_s) best = &each;
        }
        out << std::setw(12) << best->cost.realtime_factor() << std::setw(11) << best->cost.events_per_s()
            << '\n';
    }
    out << "real time: scene time over run time, and events per second of run time, of the fastest form\n";
}

void print_crossings(const ScaleReport& report, std::ostream& out) {
    out << "\nWhere the sweep takes over from prediction, on one thread\n";
    for (const ScaleCrossing& crossing : crossings(report.rows)) {
        out << std::setw(10) << grouped(crossing.elements) << " elements: ";
        if (crossing.fraction)
            out << "at " << 100 * *crossing.fraction << " % touched\n";
        else
            out << (crossing.sparse_when_idle ? "nowhere: prediction is the cheaper throughout\n"
                                              : "everywhere: the sweep is the cheaper throughout\n");
    }
}

}  // namespace

void write_scale(const ScaleReport& report, const std::filesystem::path& folder) {
    TableFile file(
        folder / "scale.csv",
        {"elements", "active_fraction", "schedule", "threads", "ranks", "realtime_factor",
         "ns_per_element_frame", "events_per_s", "bytes_per_element", "contact", "least_ns_per_element_frame",
         "most_ns_per_element_frame", "cpu_ns_per_element_frame", "nj_per_event", "measured"});
    const auto write = [&](const ScaleRow& row, const char* measured) {
        const ScalePopulation& population = row.run.population;
        const double ns_per_s = 1e9 / population.elements;
        std::optional<double> nj = row.cost.joules_per_event;
        if (nj) *nj *= 1e9;
        file.row({std::to_string(population.elements), number(population.active_fraction), name(row.run.form),
                  std::to_string(row.run.threads), std::to_string(row.ranks),
                  number(row.cost.realtime_factor()), number(row.ns()), number(row.cost.events_per_s()),
                  number(row.bytes_per_element()), name(population.contact),
                  number(row.cost.least_s * ns_per_s), number(row.cost.most_s * ns_per_s),
                  row.cost.cpu_s > 0 ? number(row.cost.cpu_s * ns_per_s) : "", known(nj), measured});
    };
    for (const ScaleRow& row : report.rows) write(row, "embedded");
    for (const ScaleRow& row : report.ranks.rows) write(row, "run");
    file.close();
    TableFile memory(folder / "scale_memory.csv", {"elements", "schedule", "adapts", "differs",
                                                   "bytes_per_element", "resident_bytes_per_element"});
    for (const ScaleMemory& each : report.memory)
        memory.row({std::to_string(each.run.population.elements), name(each.run.form),
                    each.run.population.adapts ? "1" : "0", each.run.population.differs ? "1" : "0",
                    number(each.bytes_per_element), number(each.resident_bytes_per_element)});
    memory.close();
    TableFile bandwidth(folder / "scale_bandwidth.csv", {"threads", "bytes_per_s"});
    for (const MemoryBandwidth& each : report.bandwidth)
        bandwidth.row({std::to_string(each.threads), number(each.bytes_per_s)});
    bandwidth.close();
    TableFile targets(folder / "scale_targets.csv", {"target", "value", "unit", "asked", "met"});
    for (const ScaleTarget& each : report.targets)
        targets.row({each.what, number(each.value), each.unit, known(each.asked),
                     each.asked ? (each.met() ? "1" : "0") : ""});
    targets.close();
}

void draw_scale(const ScaleReport& report, const std::filesystem::path& folder) {
    draw_by_elements(report, folder);
    draw_by_activity(report, folder);
    draw_by_threads(report, folder);
}

void print_scale(const ScaleReport& report, std::ostream& out) {
    print_rows(report, out);
    print_crossings(report, out);
    out << "\nRanks: ";
    if (!report.ranks.unavailable.empty()) out << "unavailable, " << report.ranks.unavailable << '\n';
    for (const ScaleRow& row : report.ranks.rows)
        out << (row.ranks == 1 ? "afferent run, with its sensors, by the wall clock\n" : "") << std::setw(10)
            << grouped(row.run.population.elements) << " elements, " << row.ranks
            << (row.ranks == 1 ? " rank: " : " ranks: ") << row.ns()
            << " ns per element and frame, real time " << row.cost.realtime_factor() << '\n';
    out << "\nMemory, bytes per element: as counted, and as resident by the system\n";
    for (const ScaleMemory& each : report.memory)
        out << std::setw(10) << grouped(each.run.population.elements) << std::setw(10) << name(each.run.form)
            << (each.run.population.adapts ? ", adapting" : ", not adapting")
            << (each.run.population.differs ? ", each of its own" : ", all alike") << ": "
            << each.bytes_per_element << ", " << each.resident_bytes_per_element << '\n';
    out << "\nMemory bandwidth, numbers read and written in place\n";
    for (const MemoryBandwidth& each : report.bandwidth)
        out << "  " << threads_text(each.threads) << ": " << 1e-9 * each.bytes_per_s << " GB/s\n";
    out << "\nEnergy: ";
    if (!report.no_energy.empty())
        out << "unavailable, " << report.no_energy << '\n';
    else
        out << "nj_per_event in scale.csv, of all processor packages and all that runs on them\n";
    out << "\nTargets\n";
    for (const ScaleTarget& each : report.targets) {
        out << "  " << each.what << ": " << each.value << ' ' << each.unit;
        if (each.asked)
            out << " (" << (each.at_least ? "at least " : "at most ") << *each.asked
                << (each.met() ? ", met)" : ", missed)");
        out << '\n';
    }
}

}  // namespace afferent::bench
