#include "afferent/studies/trial/experiment.hpp"

#include <algorithm>
#include <atomic>
#include <memory>
#include <thread>

#include "afferent/runtime/parallel.hpp"
#include "afferent/studies/trial/presenter.hpp"

namespace afferent {
namespace {

// Between two calls of progress, for each thread.
constexpr std::uint32_t presentations_at_once = 32;

// Empty where the user is simulated.
EmgTable recorded_emg(const Scene& scene) {
    const Result<EmgSource> source = EmgSource::open(scene);
    if (!source) throw SceneError({scene.file + ": hand.emg_table: " + source.error().text});
    return source.value().table();
}

Plan planned(const Scene& scene, const Condition& condition, const EmgTable& emg) {
    if (!scene.trial) throw SceneError({scene.file + ": trial is missing: what is presented, and to whom"});
    if (!traits_of(scene.link.transport).packets)
        throw SceneError({scene.file +
                          ": link must be one that carries packets, is in_process: a trial sends them "
                          "through its channel"});
    Scene applied = condition.applied_to(scene);
    if (!emg.times.empty())
        applied.hand.emg_table->rest_counts = EmgSource::of(scene, emg).closing_rest_counts();
    // A thread presents by itself.
    applied.runtime.threads = 1;
    return make_plan(applied, Commands::wanted);
}

}  // namespace

Experiment::Experiment(const Scene& scene, std::string_view condition)
    : condition_(afferent::condition(condition)),
      emg_(recorded_emg(scene)),
      plan_(planned(scene, condition_, emg_)),
      threads_(scene.runtime.threads > 0 ? scene.runtime.threads
                                         : std::max(1U, std::thread::hardware_concurrency())) {}

std::vector<Presentation> Experiment::present(std::uint32_t first, std::uint32_t count,
                                              const Progress& progress) const {
    const std::size_t threads = std::clamp<std::size_t>(count, 1, threads_);
    std::vector<std::unique_ptr<Presenter>> presenters(threads);
    for (auto& presenter : presenters) presenter = std::make_unique<Presenter>(plan_, condition_.feed, emg_);
    Workers workers(threads);
    std::vector<Presentation> results(count);
    std::uint32_t done = 0;
    while (done < count) {
        const std::uint32_t end =
            done + std::min(count - done, presentations_at_once * static_cast<std::uint32_t>(threads));
        std::atomic<std::uint32_t> next{done};
        workers.run(threads, [&](std::size_t worker) {
            for (std::uint32_t i = next++; i < end; i = next++)
                results[i] = presenters[worker]->present(first + i);
        });
        done = end;
        if (progress && !progress(done)) break;
    }
    results.resize(done);
    return results;
}

std::vector<TraceStep> Experiment::trace(std::uint32_t number) const {
    std::vector<TraceStep> steps;
    Presenter(plan_, condition_.feed, emg_).present(number, &steps);
    return steps;
}

}  // namespace afferent
