#include "bench/scale_targets.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <memory>
#include <numeric>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "afferent/neurons/dense_population.hpp"
#include "bench/comparison.hpp"
#include "bench/error_scene.hpp"
#include "bench/machine_memory.hpp"
#include "bench/solver.hpp"
#include "bench/table_file.hpp"
#include "bench/thread_time.hpp"

namespace afferent::bench {
namespace {

using scene::Form;

struct Sizes {
    std::uint32_t small, middle, large;

    static Sizes of(bool quick) {
        return quick ? Sizes{2'000, 20'000, 200'000} : Sizes{10'000, 100'000, 1'000'000};
    }
};

ScaleRun touched(std::uint32_t elements, Form form, std::uint32_t threads = 1) {
    return {{.elements = elements}, form, threads};
}

// A solver of bench error, on its crowd.
struct Rival {
    std::string name;
    std::unique_ptr<Solver> solver;
    std::vector<double> ns = {};  // per neuron and scan
    double rms_us = 0;            // of its spike times

    double median_ns() const {
        std::vector<double> sorted = ns;
        std::ranges::sort(sorted);
        return sorted[sorted.size() / 2];
    }
};

const ErrorScene& crowd(const std::vector<ErrorScene>& scenes) {
    return *std::ranges::find(scenes, "crowd", [](const ErrorScene& each) { return each.workload.name; });
}

// Ours are the true spikes within 1 ns. A rival whose resets come late drifts away from them, but has about
// as many.
void check(const ErrorScene& scene, const Trains& truth, Rival& rival, bool exact) {
    Trains trains(scene.workload.neurons);
    rival.solver->prepare(scene.workload);
    rival.solver->run(scene.workload, trains);
    Comparison errors;
    for (const std::size_t neuron : scene.judged) errors.add(truth[neuron], trains[neuron]);
    const auto spikes = [](const Trains& all) {
        return std::accumulate(all.begin(), all.end(), 0.0, [](double sum, const Train& each) {
            return sum + static_cast<double>(each.size());
        });
    };
    if (exact ? errors.missed + errors.extra > 0 || errors.max_s() > 1e-9
              : std::abs(spikes(trains) / spikes(truth) - 1) > 0.03)
        throw std::runtime_error(rival.name + " is wrong: " + number(spikes(trains)) +
                                 " spikes in place of " + number(spikes(truth)) + ", off by up to " +
                                 number(errors.max_s()) + " s");
    rival.rms_us = 1e6 * errors.rms_s();
}

// The populations by themselves, without encoders, scans and merging.
void against_runge_kutta(bool quick, std::vector<ScaleTarget>& targets) {
    const std::vector<ErrorScene> scenes = error_scenes(false);
    const ErrorScene& scene = crowd(scenes);
    const Workload& workload = scene.workload;
    Trains truth(workload.neurons);
    const auto exact = make_solver({"exact"});
    exact->prepare(workload);
    exact->run(workload, truth);
    constexpr double step_ms = 0.5;
    std::vector<Rival> rivals;
    rivals.push_back({"dense", make_solver({"dense"})});
    for (const char* const name : {"rk4-float", "rk4-float-interpolated", "rk4-float-corrected"})
        rivals.push_back({name, make_solver({name, step_ms})});
    for (Rival& rival : rivals) check(scene, truth, rival, rival.name == "dense");
    for (int repeat = 0; repeat < (quick ? 3 : 9); ++repeat)
        for (Rival& rival : rivals) {
            const double begin_s = thread_seconds();
            (void)rival.solver->count(workload);
            rival.ns.push_back(1e9 * (thread_seconds() - begin_s) /
                               static_cast<double>(workload.neurons * workload.rows()));
        }
    const std::string instructions = DensePopulation(LifParameters{}, 1, scale_frame).instructions();
    const bool avx512 = instructions.starts_with("AVX3");
    const double ours_ns = rivals.front().median_ns();
    // The others are off by milliseconds.
    const auto right = std::ranges::find(rivals, "rk4-float-corrected", &Rival::name);
    const char* const unit = "ns per neuron and frame";
    targets.push_back({"dense sweep of 10,000 neurons at 30 Hz, " + instructions, ours_ns, unit,
                       quick ? std::nullopt : std::optional<double>(avx512 ? 3.3 : 8)});
    for (auto rival = rivals.begin() + 1; rival != rivals.end(); ++rival) {
        std::ostringstream error;
        error << std::setprecision(2) << rival->rms_us;
        targets.push_back(
            {rival->name + " at 0.5 ms, off by " + error.str() + " us", rival->median_ns(), unit});
    }
    targets.push_back({"the one with corrected spikes over the sweep", right->median_ns() / ours_ns, "times",
                       quick ? std::nullopt : std::optional<double>(avx512 ? 1.6 : 1.2), true});
}

// Nine neurons whose drives change at every scan.
ScaleTarget prediction_target(bool quick) {
    const std::vector<ErrorScene> scenes = error_scenes(false);
    const Workload& workload = std::ranges::find(scenes, "grasp", [](const ErrorScene& each) {
                                   return each.workload.name;
                               })->workload;
    const auto exact = make_solver({"exact"});
    exact->prepare(workload);
    std::vector<double> ns;
    for (int repeat = 0; repeat < (quick ? 3 : 9); ++repeat) {
        const double begin_s = thread_seconds();
        const std::size_t spikes = exact->count(workload);
        ns.push_back(1e9 * (thread_seconds() - begin_s) /
                     static_cast<double>(workload.neurons * workload.rows() + spikes));
    }
    std::ranges::sort(ns);
    return {"prediction of nine neurons", ns[ns.size() / 2], "ns per spike or change",
            quick ? std::nullopt : std::optional<double>(70)};
}

// Memory of one population by itself.
ScaleMemory memory_of(const ScaleRun& run) {
    const ScaleTouch touch(run.population);
    const std::size_t before = resident_bytes();
    RunningScale running(run, touch);
    for (int frame = 0; frame < 20; ++frame) (void)running.frame();
    const std::size_t after = resident_bytes();
    return {run, static_cast<double>(running.coprocessor().bytes()) / run.population.elements,
            static_cast<double>(after - std::min(before, after)) / run.population.elements};
}

}  // namespace

std::vector<ScaleMemory> measure_scale_memory(bool quick, const std::function<void(double)>& progress) {
    std::vector<ScaleMemory> memory;
    for (const Form form : {Form::sparse, Form::dense, Form::automatic})
        for (const bool adapts : {true, false})
            for (const bool differs : {true, false}) {
                ScaleRun run = touched(Sizes::of(quick).large, form);
                run.population.adapts = adapts;
                run.population.differs = differs;
                memory.push_back(memory_of(run));
                progress(static_cast<double>(memory.size()) / 12);
            }
    return memory;
}

std::vector<ScaleTarget> measure_scale_targets(const std::vector<ScaleMemory>& memory, bool quick,
                                               const std::function<void(double)>& progress) {
    std::vector<ScaleTarget> targets;
    const auto add = [&](std::string what, double value, const char* unit, double asked, bool at_least) {
        targets.push_back(
            {std::move(what), value, unit, quick ? std::nullopt : std::optional(asked), at_least});
    };
    const ScaleEffort effort = quick ? ScaleEffort::quick() : ScaleEffort{.repeats = 9, .repeat_s = 0.1};
    const auto [small, middle, large] = Sizes::of(quick);
    against_runge_kutta(quick, targets);
    targets.push_back(prediction_target(quick));
    progress(0.2);

    const ScaleRun alone = touched(large / 100, Form::automatic);
    ScaleRun part = touched(large, Form::automatic);
    part.population.active_fraction = 0.01;
    ScaleRun scattered = part;
    scattered.population.contact = Contact::scattered;
    ScaleRun scattered_alone = alone;
    scattered_alone.population.contact = Contact::scattered;
    const auto parts = measure_together({alone, part, scattered_alone, scattered}, effort);
    const std::string of_them = std::to_string(large) + " elements, 1 % touched, over those alone";
    add(of_them + ": a block", parts[1].frame_s / parts[0].frame_s, "times", 1.3, false);
    targets.push_back({of_them + ": scattered", parts[3].frame_s / parts[2].frame_s, "times"});
    progress(0.4);

    for (const Form form : {Form::dense, Form::automatic}) {
        const auto flat =
            measure_together({touched(small, form), touched(middle, form), touched(large, form)}, effort);
        const std::array ns{flat[0].ns_per_element_frame(small), flat[1].ns_per_element_frame(middle),
                            flat[2].ns_per_element_frame(large)};
        add("all touched, " + name(form) + ": dearest over cheapest element of " + std::to_string(small) +
                " to " + std::to_string(large),
            *std::ranges::max_element(ns) / *std::ranges::min_element(ns), "times", 1.2, false);
        progress(form == Form::dense ? 0.6 : 0.7);
    }
    if (scale_threads().size() > 1)
        for (const Form form : {Form::sparse, Form::dense, Form::automatic}) {
            const std::uint32_t elements = form == Form::sparse ? middle : large;
            const auto threads =
                measure_together({touched(elements, form), touched(elements, form, 2)}, effort);
            // By the wall clock; the least repeats are those in which nobody else was served.
            add("two threads over one, " + name(form) + ", " + std::to_string(elements) + " elements",
                threads[0].least_wall_s / threads[1].least_wall_s, "times", 1.85, true);
        }
    progress(1);
    for (const ScaleMemory& each : memory)
        if (each.run.form == Form::dense)
            add(std::string("memory, dense, ") + (each.run.population.adapts ? "adapting" : "not adapting") +
                    (each.run.population.differs ? ", each its own threshold and phase" : ", all alike"),
                each.bytes_per_element, "bytes per element", each.run.population.differs ? 24 : 12, false);
    return targets;
}

std::vector<ScaleTarget> two_ranks_targets(const ScaleRanks& ranks, bool quick) {
    const ScaleRow& alone = ranks.rows[0];
    const double alone_s = alone.cost.least_wall_s;
    const std::string of = std::to_string(alone.run.population.elements) + " elements";
    return {{"two ranks over one, afferent run, " + of, alone_s / ranks.rows[1].cost.least_wall_s, "times",
             quick ? std::nullopt : std::optional<double>(1.8), true},
            {"two processes of half of them each that exchange nothing, over one, afferent run, " + of,
             alone_s / ranks.halves_s, "times"}};
}

}  // namespace afferent::bench
