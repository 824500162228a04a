#include "bench/scale_bench.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <map>
#include <stdexcept>
#include <thread>
#include <tuple>
#include <utility>

#include "bench/energy_meter.hpp"

namespace afferent::bench {
namespace {

// Below it a second thread has nothing to do.
constexpr std::uint32_t worth_threads = 10'000;

double wall_s() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double process_s() {
    timespec time;
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

std::string name_of(const ScaleRun& run) {
    return name(run.form) + " on " + std::to_string(run.threads) +
           (run.threads == 1 ? " thread" : " threads");
}

// A run, the touch that it feels, and what has been measured of it.
struct Runner {
    const ScaleRun& run;
    RunningScale running;
    double settling_frame_s = 0;  // the last one
    std::uint64_t frames_a_repeat = 2;
    std::vector<double> wall_s = {};
    std::vector<double> cpu_s = {};
    double events = 0;
    double frames = 0;
    double joules = 0;
    bool joules_known = true;
};

// Advances runs of one population side by side, and holds their events against each other.
void settle(std::vector<Runner*>& runs, std::uint64_t frames) {
    struct OfForm {
        const Runner* first;
        std::vector<Event> events;
    };
    std::map<scene::Form, OfForm> forms;
    for (const Runner* each : runs) forms.try_emplace(each->run.form, OfForm{each, {}});
    for (std::uint64_t k = 0; k < frames; ++k) {
        std::map<scene::Form, std::span<const Event>> firsts;
        for (Runner* each : runs) {
            const double begin_s = wall_s();
            const std::span<const Event> events = each->running.frame();
            each->settling_frame_s = wall_s() - begin_s;
            const auto [first, added] = firsts.try_emplace(each->run.form, events);
            if (added) {
                auto& all = forms.at(each->run.form).events;
                all.insert(all.end(), events.begin(), events.end());
            } else if (!std::ranges::equal(first->second, events)) {
                throw std::runtime_error(name_of(each->run) + " has other events than " +
                                         name_of(forms.at(each->run.form).first->run));
            }
        }
    }
    const TimePoint end = scene_start + static_cast<Duration::rep>(frames) * scale_frame;
    OfForm& reference = forms.begin()->second;
    for (auto& [form, other] : forms)
        if (&other != &reference)
            require_same_events(reference.events, other.events, end,
                                name_of(reference.first->run) + " and " + name_of(other.first->run));
}

void measure_repeat(Runner& each, EnergyMeter& energy) {
    (void)energy.joules();
    const double begin_s = wall_s();
    const double begin_cpu_s = process_s();
    std::size_t events = 0;
    for (std::uint64_t k = 0; k < each.frames_a_repeat; ++k) events += each.running.frame().size();
    const auto frames = static_cast<double>(each.frames_a_repeat);
    each.wall_s.push_back((wall_s() - begin_s) / frames);
    each.cpu_s.push_back((process_s() - begin_cpu_s) / frames);
    const std::optional<double> joules = energy.joules();
    each.joules += joules.value_or(0);
    each.joules_known = each.joules_known && joules;
    each.events += static_cast<double>(events);
    each.frames += frames;
}

ScaleCost cost_of(const Runner& each) {
    const std::vector<double>& took_s = each.run.threads == 1 ? each.cpu_s : each.wall_s;
    ScaleCost cost{.frame_s = median(took_s),
                   .least_s = *std::ranges::min_element(took_s),
                   .most_s = *std::ranges::max_element(took_s),
                   .least_wall_s = *std::ranges::min_element(each.wall_s),
                   .cpu_s = median(each.cpu_s),
                   .events_per_frame = each.events / each.frames,
                   .bytes = each.running.coprocessor().bytes()};
    if (each.joules_known && each.events > 0) cost.joules_per_event = each.joules / each.events;
    return cost;
}

std::vector<ScaleRun> runs_of(const ScalePopulation& population) {
    std::vector<ScaleRun> runs;
    for (const scene::Form form : {scene::Form::sparse, scene::Form::dense, scene::Form::automatic})
        for (const std::uint32_t threads : scale_threads())
            if (threads == 1 || population.elements >= worth_threads)
                runs.push_back({population, form, threads});
    return runs;
}

std::vector<ScalePopulation> populations_of(const ScaleOptions& options) {
    std::vector<ScalePopulation> populations;
    for (const std::uint32_t elements : options.elements)
        for (const Contact contact : {Contact::block, Contact::scattered})
            for (const double fraction : {0.0, 0.01, 0.03, 0.1, 0.3, 1.0}) {
                const ScalePopulation population{elements, fraction, contact};
                const bool none_of_a_few = fraction > 0 && population.active() == 0;
                const bool same_as_a_block =
                    contact == Contact::scattered && (fraction == 0 || fraction > 0.1);
                if (!none_of_a_few && !same_as_a_block) populations.push_back(population);
            }
    return populations;
}

}  // namespace

void require_same_events(std::vector<Event>& these, std::vector<Event>& those, TimePoint end,
                         const std::string& names) {
    const auto by_address = [](const Event& a, const Event& b) {
        return std::tie(a.address, a.time) < std::tie(b.address, b.time);
    };
    std::ranges::sort(these, by_address);
    std::ranges::sort(those, by_address);
    auto a = these.begin();
    auto b = those.begin();
    while (a != these.end() || b != those.end()) {
        const bool both = a != these.end() && b != those.end();
        if (both && a->address == b->address && std::chrono::abs(a->time - b->time) <= Duration(1)) {
            ++a;
            ++b;
            continue;
        }
        auto& alone = b == those.end() || (both && by_address(*a, *b)) ? a : b;
        if (alone->time < end - Duration(2))
            throw std::runtime_error(names + " differ in the event of afferent " +
                                     std::to_string(alone->address) + " at " +
                                     std::to_string(seconds(alone->time)) + " s");
        ++alone;
    }
}

std::vector<std::uint32_t> scale_threads() {
    const std::uint32_t most = std::max(1U, std::thread::hardware_concurrency());
    std::vector<std::uint32_t> threads;
    for (std::uint32_t count = 1; count < most; count *= 2) threads.push_back(count);
    threads.push_back(most);
    return threads;
}

std::vector<ScaleCost> measure_together(const std::vector<ScaleRun>& runs, const ScaleEffort& effort) {
    // Runs of one population feel the same touch.
    std::vector<ScalePopulation> populations;
    for (const ScaleRun& run : runs)
        if (std::ranges::find(populations, run.population) == populations.end())
            populations.push_back(run.population);
    const std::vector<ScaleTouch> touches(populations.begin(), populations.end());
    std::vector<Runner> runners;
    runners.reserve(runs.size());
    std::vector<std::vector<Runner*>> alike(populations.size());
    for (const ScaleRun& run : runs) {
        const auto i =
            static_cast<std::size_t>(std::ranges::find(populations, run.population) - populations.begin());
        alike[i].push_back(&runners.emplace_back(Runner{run, RunningScale(run, touches[i])}));
    }
    for (auto& of_population : alike) settle(of_population, effort.settling_frames);
    for (Runner& each : runners)
        each.frames_a_repeat = static_cast<std::uint64_t>(
            std::clamp(effort.repeat_s / std::max(1e-9, each.settling_frame_s), 2.0, 1e5));
    EnergyMeter energy;
    for (std::size_t repeat = 0; repeat < effort.repeats; ++repeat)
        for (Runner& each : runners) measure_repeat(each, energy);
    std::vector<ScaleCost> costs;
    for (const Runner& each : runners) costs.push_back(cost_of(each));
    return costs;
}

std::vector<ScaleRow> measure_scale(const ScaleOptions& options,
                                    const std::function<void(double)>& progress) {
    const std::vector<ScalePopulation> populations = populations_of(options);
    // The time that a population takes, roughly.
    const auto weight = [](const ScalePopulation& each) {
        return 20'000 + each.elements + 4.0 * each.active();
    };
    double all = 0;
    for (const ScalePopulation& each : populations) all += weight(each);
    double done = 0;
    std::vector<ScaleRow> rows;
    for (const ScalePopulation& each : populations) {
        const std::vector<ScaleRun> runs = runs_of(each);
        const std::vector<ScaleCost> costs = measure_together(runs, options.effort());
        for (std::size_t i = 0; i < runs.size(); ++i) rows.push_back({runs[i], costs[i]});
        progress((done += weight(each)) / all);
    }
    return rows;
}

std::vector<ScaleCrossing> crossings(const std::vector<ScaleRow>& rows) {
    // By elements and fraction: what the sweep costs more than prediction.
    std::map<std::uint32_t, std::map<double, double>> excess_ns;
    for (const ScaleRow& row : rows) {
        const ScalePopulation& population = row.run.population;
        if (row.run.threads > 1 || population.contact != Contact::block) continue;
        double& excess = excess_ns[population.elements][population.active_fraction];
        if (row.run.form == scene::Form::dense) excess += row.ns();
        if (row.run.form == scene::Form::sparse) excess -= row.ns();
    }
    std::vector<ScaleCrossing> found;
    for (const auto& [elements, by_fraction] : excess_ns) {
        ScaleCrossing crossing{elements, {}, by_fraction.begin()->second > 0};
        for (auto at = by_fraction.begin(); std::next(at) != by_fraction.end(); ++at) {
            const auto& [low, low_ns] = *at;
            const auto& [high, high_ns] = *std::next(at);
            // Both forms cost about so much for every element that is touched: linear in the fraction.
            if ((low_ns > 0) != (high_ns > 0)) {
                crossing.fraction = low + (high - low) * low_ns / (low_ns - high_ns);
                break;
            }
        }
        found.push_back(crossing);
    }
    return found;
}

}  // namespace afferent::bench
