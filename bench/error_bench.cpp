#include "bench/error_bench.hpp"

#include <hwy/targets.h>
#include <algorithm>
#include <iomanip>
#include <map>
#include <optional>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "afferent/io/pictures/scatter_picture.hpp"
#include "afferent/neurons/dense_population.hpp"
#include "bench/comparison.hpp"
#include "bench/force_error.hpp"
#include "bench/solver.hpp"
#include "bench/table_file.hpp"
#include "bench/thread_time.hpp"
#include "bench/truth.hpp"

namespace afferent::bench {
namespace {

struct Contestant {
    std::string label;
    SolverSpec spec;
    std::int64_t target = 0;  // the one instruction set to use; 0: the best
    bool stiff_only = false;
    std::size_t most_neurons = 100'000;  // with more it takes minutes
};

// The instruction sets that this machine has and the dense form is compiled for, best first.
std::vector<std::pair<std::string, std::int64_t>> instruction_sets() {
    std::vector<std::pair<std::string, std::int64_t>> sets;
    for (std::int64_t targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
        const std::int64_t target = targets & -targets;
        hwy::SetSupportedTargetsForTest(target);
        const std::string name = DensePopulation(LifParameters{}, 1, 5ms).instructions();
        if (name == hwy::TargetName(target)) sets.emplace_back(name, target);
        hwy::SetSupportedTargetsForTest(0);
    }
    return sets;
}

std::vector<Contestant> contestants(bool quick) {
    std::vector<Contestant> all{{"exact", {"exact"}, 0, false}};
    for (const auto& [name, target] : instruction_sets()) {
        all.push_back({"dense " + name, {"dense"}, target, false});
        if (quick) break;
    }
    const auto add = [&](const std::string& name, std::vector<double> settings, bool stiff_only = false) {
        for (const double setting : settings)
            if (!quick || setting == settings[settings.size() / 2])
                all.push_back({name, {name, setting}, 0, stiff_only});
    };
    // The neuron of a chip, on ticks of 1 and 0.1 ms: what its integers cost beside the exact one.
    for (const std::string& name : fixed_point_solver_names()) add(name, {1, 0.1});
    for (const std::string& name : stepping_solver_names()) {
        if (name.starts_with("rk4-float") && name != "rk4-float-corrected") continue;
        add(name, name.starts_with("rk4") ? std::vector<double>{1, 0.5, 0.1, 0.01}
                                          : std::vector<double>{1, 0.1, 0.01});
    }
    // The strongest rival on the instruction sets that ours is shown on.
    for (const auto& [name, target] : instruction_sets()) {
        if (quick) break;
        all.push_back({"rk4-float-corrected " + name, {"rk4-float-corrected", 0.5}, target});
    }
    add("dopri5", {1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12});
    add("rosenbrock", {1e-3, 1e-6, 1e-9}, true);
    for (const std::string& name : cvode_solver_names()) add(name, {1e-4, 1e-6, 1e-8, 1e-10});
    for (Contestant& contestant : all)
        if (contestant.label == "cvode") contestant.most_neurons = 100;
    return all;
}

// The median run in ns per neuron and row, over enough runs to stand out from noise.
double time_ns(Solver& solver, const Workload& workload, bool quick) {
    std::vector<double> runs_s;
    double total_s = 0;
    const double enough_s = quick ? 0.02 : 0.3;
    while (runs_s.empty() ||
           (runs_s.size() < 101 && total_s < (runs_s.size() < 5 ? 10 * enough_s : enough_s))) {
        const double begin_s = bench::thread_seconds();
        solver.count(workload);
        runs_s.push_back(bench::thread_seconds() - begin_s);
        total_s += runs_s.back();
    }
    const auto middle = runs_s.begin() + static_cast<std::ptrdiff_t>(runs_s.size() / 2);
    std::nth_element(runs_s.begin(), middle, runs_s.end());
    return *middle * 1e9 / static_cast<double>(workload.neurons * workload.rows());
}

// Highway calls AVX-512 by a name of its own, AVX3.
std::string instructions(const std::string& target) {
    return target.starts_with("AVX3") ? "AVX-512" + target.substr(4) : target;
}

// A contestant as a legend names it, and which of the kinds it is that share a colour.
std::pair<std::string, std::size_t> in_words(const std::string& label) {
    std::string rest = label;
    const auto begins = [&](const std::string& with) {
        if (!rest.starts_with(with)) return false;
        rest.erase(0, with.size());
        return true;
    };
    if (label == "exact") return {"Afferent, by prediction", 0};
    if (begins("dense ")) return {"Afferent, by a sweep, " + instructions(rest), 5};
    if (begins("fixed-")) {
        const std::size_t end = rest.find('-');
        return {"in integers of " + rest.substr(0, end) + " bits" +
                    (end == std::string::npos ? "" : ", " + rest.substr(end + 1)),
                6};
    }
    if (label == "dopri5") return {"Dormand–Prince, dense output", 4};
    if (label == "rosenbrock") return {"Rosenbrock 4, dense output", 4};
    if (begins("cvode")) return {"CVODE" + rest, 4};
    std::string method;
    std::size_t kind = 0;
    if (begins("exponential-euler")) {
        method = "exponential Euler";
        kind = 7;
    } else if (begins("euler")) {
        method = "forward Euler";
        kind = 1;
    } else if (begins("rk4-float")) {
        method = "Runge–Kutta 4 in float";
        kind = 3;
    } else if (begins("rk4")) {
        method = "Runge–Kutta 4";
        kind = 2;
    }
    if (begins("-interpolated")) method += ", spike inside the step";
    if (begins("-corrected")) method += ", spike and reset inside the step";
    return {method + (rest.empty() ? "" : "," + rest), kind};
}

// Three digits; empty where the value is not known.
std::string shown(std::optional<double> value) {
    if (!value) return "";
    std::ostringstream text;
    text << std::setprecision(3) << *value;
    return text.str();
}

class ErrorTable {
  public:
    ErrorTable(const ErrorBench& bench, std::ostream& report)
        : bench_(bench),
          report_(report),
          file_(bench.out / "error.csv", {"scene", "solver", "setting", "ns_per_neuron_scan", "median_us",
                                          "p95_us", "rms_us", "max_us", "missed", "extra", "force_rms_n"}) {}

    void scene(const ErrorScene& scene) {
        const Workload& workload = scene.workload;
        Trains truth(workload.neurons);
        std::size_t spikes = 0;
        for (const std::size_t neuron : scene.judged) {
            truth[neuron] = true_train(workload, neuron);
            spikes += truth[neuron].size();
        }
        report_ << "\nScene " << workload.name << ": " << workload.neurons << " neurons, " << workload.rows()
                << " rows, " << spikes << " true spikes of " << scene.judged.size()
                << " neurons\nForce error of the true spikes, N: " << shown(force_rms_n(scene, truth)) << '\n'
                << std::left << std::setw(32) << "solver" << std::right << std::setw(12) << "ns/n/scan"
                << std::setw(11) << "median us" << std::setw(11) << "p95 us" << std::setw(11) << "rms us"
                << std::setw(11) << "max us" << std::setw(8) << "missed" << std::setw(8) << "extra"
                << std::setw(12) << "force rms N" << '\n';
        std::map<std::string, ScatterPicture::Series> series;
        for (const Contestant& contestant : contestants(bench_.quick)) {
            if (contestant.stiff_only && workload.name != "stiff") continue;
            if (workload.neurons > contestant.most_neurons) continue;
            one(scene, truth, contestant, series);
        }
        draw_picture(workload.name, series);
    }

    void close() { file_.close(); }

  private:
    void one(const ErrorScene& scene, const Trains& truth, const Contestant& contestant,
             std::map<std::string, ScatterPicture::Series>& series) {
        const Workload& workload = scene.workload;
        const std::string label = SolverSpec{contestant.label, contestant.spec.setting}.text();
        hwy::SetSupportedTargetsForTest(contestant.target);
        Trains trains(workload.neurons);
        double ns = 0;
        std::optional<std::string> reason;
        try {
            const auto solver = make_solver(contestant.spec);
            solver->prepare(workload);
            solver->run(workload, trains);
            ns = time_ns(*solver, workload, bench_.quick);
        } catch (const Unserved& unserved) {
            reason = unserved.what();
        }
        hwy::SetSupportedTargetsForTest(0);
        report_ << std::left << std::setw(32) << label << std::right;
        if (reason) {
            report_ << "  " << *reason << '\n';
            return;
        }
        Comparison errors;
        for (const std::size_t neuron : scene.judged) errors.add(truth[neuron], trains[neuron]);
        const double us = 1e6;
        const std::string force_n = shown(force_rms_n(scene, trains));
        report_ << std::setprecision(3) << std::setw(12) << ns;
        for (const double error_s :
             {errors.quantile_s(0.5), errors.quantile_s(0.95), errors.rms_s(), errors.max_s()})
            report_ << std::setw(11) << error_s * us;
        report_ << std::setw(8) << errors.missed << std::setw(8) << errors.extra << std::setw(12) << force_n
                << '\n'
                << std::flush;
        file_.row({workload.name, contestant.label, number(contestant.spec.setting), number(ns),
                   number(errors.quantile_s(0.5) * us), number(errors.quantile_s(0.95) * us),
                   number(errors.rms_s() * us), number(errors.max_s() * us), std::to_string(errors.missed),
                   std::to_string(errors.extra), force_n});
        ScatterPicture::Series& line = series[contestant.label];
        std::tie(line.name, line.kind) = in_words(contestant.label);
        // An error of zero has no place on a logarithmic axis.
        line.points.push_back({ns, std::max(errors.rms_s(), 1e-18) * us});
    }

    void draw_picture(const std::string& scene, const std::map<std::string, ScatterPicture::Series>& series) {
        ScatterPicture picture{"Error against run time: " + scene,
                               "run time, ns per neuron and scan",
                               "RMS error of a spike time, µs",
                               {}};
        for (const auto& [label, line] : series) picture.series.push_back(line);
        // Ours first; then the methods, each with what it is given beside; 8 bits before 12.
        std::ranges::stable_sort(picture.series, [](const auto& a, const auto& b) {
            const auto place = [](const auto& line) {
                return std::tuple(!line.name.starts_with("Afferent"), *line.kind, line.name.find(" bits"));
            };
            return place(a) < place(b);
        });
        const Drawing drawing = draw(picture, bench_.out / ("error_" + scene));
        if (drawing.outcome == Drawn::no_gnuplot) report_ << "No picture: gnuplot is not installed\n";
        if (drawing.outcome == Drawn::failed) report_ << "No picture: " << drawing.message << '\n';
    }

    const ErrorBench& bench_;
    std::ostream& report_;
    TableFile file_;
};

// The error of the last spike of so many seconds under one held drive, against truth in closed form.
void run_length(const ErrorBench& bench, std::ostream& report) {
    const LifParameters parameters;
    constexpr double drive_mv = 45;
    const SettledTrain truth(parameters, drive_mv);
    TableFile file(bench.out / "length.csv", {"solver", "run_s", "spikes", "error_ns"});
    report << "\nError of the last spike over the length of a run, one neuron under a held drive\n"
           << std::left << std::setw(32) << "solver" << std::right << std::setw(10) << "run s"
           << std::setw(12) << "spikes" << std::setw(14) << "error ns" << '\n';
    struct Run {
        SolverSpec spec;
        double longest_s;
    };
    for (const Run& run :
         {Run{{"exact"}, bench.quick ? 3600.0 : 86400.0}, Run{{"dense"}, bench.quick ? 60.0 : 86400.0},
          Run{{"rk4-corrected", 0.5}, bench.quick ? 60.0 : 3600.0},
          Run{{"dopri5", 1e-10}, bench.quick ? 1.0 : 60.0}}) {
        for (const double length_s : {1.0, 60.0, 3600.0, 86400.0}) {
            if (length_s > run.longest_s) continue;
            Workload workload;
            workload.parameters = {parameters};
            workload.until = scene_start + rounded(Seconds(length_s));
            // A row at a time: the drive stays, and so does every clock.
            const Duration scan_interval = run.spec.name == "dense" ? Duration(5ms) : Duration(1s);
            for (TimePoint time = scene_start; time < workload.until; time += scan_interval) {
                workload.times.push_back(time);
                workload.drives_mv.push_back(drive_mv);
            }
            Trains trains(1);
            const auto solver = make_solver(run.spec);
            solver->prepare(workload);
            solver->run(workload, trains);
            if (trains[0].empty()) continue;
            const std::size_t last = trains[0].size() - 1;
            const double error_ns = std::abs((trains[0][last] - truth.spike(last)).count());
            report << std::left << std::setw(32) << run.spec.text() << std::right << std::setw(10) << length_s
                   << std::setw(12) << last + 1 << std::setw(14) << std::setprecision(3) << error_ns << '\n'
                   << std::flush;
            file.row({run.spec.text(), number(length_s), std::to_string(last + 1), number(error_ns)});
        }
    }
    file.close();
}

}  // namespace

void run_error_bench(const ErrorBench& bench, std::ostream& report) {
    ErrorTable table(bench, report);
    for (const ErrorScene& scene : bench.scenes) table.scene(scene);
    table.close();
    run_length(bench, report);
}

}  // namespace afferent::bench
