#include "bench/decoding_judge.hpp"

#include <algorithm>
#include <iomanip>
#include <limits>
#include <mutex>
#include <thread>

#include "afferent/runtime/parallel.hpp"
#include "bench/decoding_bench.hpp"
#include "bench/spike_particles.hpp"
#include "bench/table_file.hpp"

namespace afferent {
namespace {

constexpr Duration judged_tick = 100us;
constexpr Duration judged_deadline = 5ms;
constexpr std::size_t most_afferents = 9;

bool judged(const Touch& touch) {
    return std::all_of(touch.forces.begin(), touch.forces.end(), [](const TouchedForce& force) {
        return force.afferents.afferents.size() <= most_afferents;
    });
}

double rms_n(const std::vector<FollowedForce>& followed) { return score(followed, Touch::step).rms_sensed_n; }

double particles_rms_n(const Touch& touch, std::uint64_t seed) {
    std::vector<FollowedForce> followed;
    for (const TouchedForce& force : touch.forces)
        if (force.touched())
            followed.push_back({force.true_n, force.sensed_n, force.sensed_n,
                                follow_by_particles(force, judged_tick, judged_deadline, {.seed = seed})});
    return rms_n(followed);
}

Judgement judge(Touch touch, std::uint64_t runs) {
    for (TouchedForce& force : touch.forces) force.afferents.hysteresis = 0;
    double best_n = std::numeric_limits<double>::infinity();
    for (std::uint64_t seed = 1; seed <= runs; ++seed)
        best_n = std::min(best_n, particles_rms_n(touch, seed));
    return {touch.name, touch.elements(),
            rms_n(follow(touch, {"events", "filter", judged_tick, judged_deadline})), best_n};
}

}  // namespace

std::vector<Judgement> judge_filter(const std::vector<Touch>& touches, std::uint64_t runs,
                                    const std::function<void(double)>& progress) {
    std::vector<const Touch*> all;
    for (const Touch& touch : touches)
        if (judged(touch)) all.push_back(&touch);
    std::vector<Judgement> judgements(all.size());
    std::mutex reporting;
    std::size_t done = 0;
    Workers(std::max(1U, std::thread::hardware_concurrency())).run(all.size(), [&](std::size_t i) {
        judgements[i] = judge(*all[i], runs);
        const std::lock_guard lock(reporting);
        progress(static_cast<double>(++done) / static_cast<double>(all.size()));
    });
    return judgements;
}

void write_judgements(const std::vector<Judgement>& judgements, const std::filesystem::path& folder) {
    bench::TableFile file(folder / "judge.csv",
                          {"scene", "elements", "filter_rms_sensed_n", "particles_rms_sensed_n"});
    for (const Judgement& row : judgements)
        file.row({row.scene, std::to_string(row.elements), bench::number(row.filter_rms_n),
                  bench::number(row.particles_rms_n)});
    file.close();
}

void print_judgements(const std::vector<Judgement>& judgements, std::ostream& out) {
    out << "\nThe filter against particles that know its force model without its approximations, RMS N of "
           "the "
           "sensed force\n"
        << std::setprecision(3);
    for (const Judgement& row : judgements)
        out << "  " << std::left << std::setw(26) << row.scene + ", " + std::to_string(row.elements)
            << std::right << std::setw(10) << row.filter_rms_n << std::setw(10) << row.particles_rms_n
            << std::setw(10) << row.ratio() << " times\n";
}

}  // namespace afferent
