#include "bench/robust_bench.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "afferent/runtime/parallel.hpp"
#include "bench/decoding_bench.hpp"

namespace afferent {
namespace {

// One case on the grips that share a name.
struct Task {
    const RobustCase* what;
    std::vector<World> worlds;
    std::vector<RobustRow> rows = {};
};

std::vector<std::string> decoders_of(const RobustOptions& options) {
    std::vector<std::string> known{read_by_sensors};
    for (const NamedDecoder& decoder : named_decoders()) known.push_back(decoder.name);
    if (options.decoders.empty()) return known;
    for (const std::string& name : options.decoders)
        if (std::ranges::find(known, name) == known.end())
            throw std::runtime_error("no decoder is called \"" + name + "\"");
    return options.decoders;
}

std::vector<const RobustCase*> cases_of(const RobustOptions& options) {
    std::vector<const RobustCase*> chosen;
    std::string known;
    for (const RobustCase& each : robust_cases()) {
        known += (known.empty() ? "" : ", ") + each.name;
        const bool named = std::ranges::any_of(
            options.cases, [&](const std::string& name) { return each.name.starts_with(name); });
        if (options.cases.empty() ? !options.quick || each.quick : named) chosen.push_back(&each);
    }
    for (const std::string& name : options.cases)
        if (std::ranges::none_of(chosen, [&](const auto* each) { return each->name.starts_with(name); }))
            throw std::runtime_error("no case is called \"" + name + "\"; there are " + known);
    return chosen;
}

// One for each case and scene.
std::vector<Task> tasks_of(const RobustInput& input, const std::vector<const RobustCase*>& cases) {
    std::vector<Task> tasks;
    for (const RobustCase* what : cases)
        for (World& world : what->worlds(input)) {
            if (tasks.empty() || tasks.back().what != what || tasks.back().worlds.front().name != world.name)
                tasks.push_back({what, {}});
            tasks.back().worlds.push_back(std::move(world));
        }
    return tasks;
}

// Decoders by their description: constructing the curves of some takes half a second, and most cases share
// one.
class MadeDecoders {
  public:
    GripDecoder of(const NamedDecoder& decoder, const DecodedAfferents& afferents) {
        {
            const std::lock_guard lock(mutex_);
            for (const Made& each : made_)
                if (each.name == decoder.name && each.afferents == afferents) return each.decoder;
        }
        GripDecoder made(decoder.parameters, afferents);
        const std::lock_guard lock(mutex_);
        made_.push_back({decoder.name, afferents, made});
        return made;
    }

  private:
    struct Made {
        std::string name;
        DecodedAfferents afferents;
        GripDecoder decoder;
    };
    std::mutex mutex_;
    std::vector<Made> made_;
};

// No other decoder reads DecodedAfferents::uncertainty.
bool heeds_uncertainty(const std::string& decoder) { return decoder == "filter"; }

std::vector<Estimate> read_by(const TouchedForce& force) {
    std::vector<Estimate> readings;
    for (const double sensed_n : force.sensed_n) readings.push_back({.force_n = sensed_n});
    return readings;
}

void judge(const World& world, const TouchedForce& force, const std::vector<Estimate>& estimates,
           RobustScore& score) {
    const std::vector<bool> counts = judged(world, force.true_n);
    for (std::size_t k = 0; k < estimates.size(); ++k) {
        if (!counts[k]) continue;
        Estimate estimate = estimates[k];
        estimate.force_n /= world.unit_n;
        estimate.sigma_n /= world.unit_n;
        score.add(force.true_n[k] / world.unit_n, estimate);
    }
}

void carry_out(Task& task, const std::vector<std::string>& decoders, MadeDecoders& made) {
    const RobustCase& what = *task.what;
    for (const bool stated : {false, true})
        for (const std::string& decoder : decoders)
            if (!stated || (what.stated && heeds_uncertainty(decoder)))
                task.rows.push_back({&what, task.worlds.front().name, decoder, stated});
    for (const World& told : task.worlds)
        for (unsigned draw = 0; draw < what.draws; ++draw) {
            World world = told;
            what.change(world, draw);
            const TouchedForce force = touched_force(world);
            DecodingCell cell{"events", {}, 100us, 5ms};
            cell.lost = world.lost;
            cell.draw = world.draw;
            DecodedAfferents afferents = world.afferents;
            afferents.tick = *cell.tick;
            for (RobustRow& row : task.rows) {
                afferents.uncertainty = row.stated ? *what.stated : world.afferents.uncertainty;
                const auto decoder = std::ranges::find(named_decoders(), row.decoder, &NamedDecoder::name);
                judge(world, force,
                      row.decoder == read_by_sensors
                          ? read_by(force)
                          : follow_events(force, cell, made.of(*decoder, afferents)),
                      row.score);
            }
        }
    for (RobustRow& row : task.rows) row.score.finish();
}

}  // namespace

void RobustScore::add(double true_n, const Estimate& estimate) {
    const double error_n = estimate.force_n - true_n;
    rms_n += error_n * error_n;
    bias_n += error_n;
    coverage_95 += std::abs(error_n) <= 1.96 * estimate.sigma_n;
    above_2_sigma += -error_n > 2 * estimate.sigma_n;
    left_out += estimate.left_out;
    saturated += estimate.doubt == Doubt::saturated;
    doubtful += estimate.doubt != Doubt::none;
    ++steps;
}

void RobustScore::finish() {
    const double n = std::max(1.0, static_cast<double>(steps));
    for (double* each : {&rms_n, &bias_n, &coverage_95, &above_2_sigma, &left_out, &saturated, &doubtful})
        *each /= n;
    rms_n = std::sqrt(rms_n);
}

std::vector<RobustRow> measure_robustness(const RobustInput& input, const RobustOptions& options,
                                          const std::function<void(double)>& progress) {
    const std::vector<std::string> decoders = decoders_of(options);
    std::vector<Task> tasks = tasks_of(input, cases_of(options));
    MadeDecoders made;
    std::mutex reporting;
    std::size_t done = 0;
    Workers(std::max(1U, std::thread::hardware_concurrency())).run(tasks.size(), [&](std::size_t i) {
        carry_out(tasks[i], decoders, made);
        const std::lock_guard lock(reporting);
        progress(static_cast<double>(++done) / static_cast<double>(tasks.size()));
    });
    std::vector<RobustRow> rows;
    for (Task& task : tasks) rows.insert(rows.end(), task.rows.begin(), task.rows.end());
    return rows;
}

}  // namespace afferent
