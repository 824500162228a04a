#include "afferent/studies/sweep.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "afferent/nodes/force_error.hpp"
#include "afferent/nodes/run.hpp"
#include "afferent/runtime/parallel.hpp"

namespace afferent {
namespace {

using Clock = std::chrono::steady_clock;

// Whether a run goes on, which is asked every few hundred steps with the fraction that is done.
using GoesOn = std::function<bool(double fraction)>;

class Figures {
  public:
    void step(const ControllerStep& step) {
        lowest_gain_ = std::min(lowest_gain_.value_or(step.gain), step.gain);
        if (!step.true_force_n) return;
        const double error_n = step.estimate.force_n - *step.true_force_n;
        error_.add(step.estimate.force_n, *step.true_force_n);
        ++steps_;
        if (std::abs(error_n) <= 2 * step.estimate.sigma_n) ++within_;
    }

    RunFigures of(const Run& run) const {
        RunFigures figures;
        figures.duration_s = seconds(run.plan().end());
        figures.events = run.coprocessor().events();
        figures.packets = run.packets();
        figures.link_bytes = run.link_bytes();
        figures.raw_sample_bytes = run.coprocessor().raw_sample_bytes();
        figures.force_error_rms_n = error_.rms_n();
        figures.force_error_max_n = error_.max_n();
        if (steps_) figures.within_two_sigmas = static_cast<double>(within_) / static_cast<double>(steps_);
        figures.lowest_gain = lowest_gain_;
        return figures;
    }

  private:
    ForceError error_;
    std::optional<double> lowest_gain_;
    std::uint64_t steps_ = 0;
    std::uint64_t within_ = 0;
};

// Nothing: it was stopped.
Result<std::optional<RunFigures>> run(const Plan& plan, const GoesOn& goes_on) {
    Figures figures;
    const auto began = Clock::now();
    auto opened = Run::open(plan, {.step = [&](const ControllerStep& step) { figures.step(step); }});
    if (!opened) return opened.error();
    Run& run = *opened.value();
    for (std::uint64_t steps = 0; !run.done(); ++steps) {
        if (steps % 512 == 0 && !goes_on(seconds(run.next()) / seconds(plan.end())))
            return std::optional<RunFigures>();
        if (auto done = run.do_next(); !done) return done.error();
    }
    run.finish(plan.end());
    RunFigures came_to = figures.of(run);
    came_to.run_time_s = Seconds(Clock::now() - began).count();
    return std::optional(came_to);
}

std::vector<SweepPoint> combinations(std::span<const SweepAxis> axes) {
    std::size_t count = 1;
    for (const SweepAxis& axis : axes) {
        if (axis.values.empty()) throw SceneError({axis.path + ": has no values to sweep over"});
        if (axis.values.size() > most_sweep_points / count)
            throw SceneError({"a sweep has at most " + std::to_string(most_sweep_points) +
                              " combinations, this has more"});
        count *= axis.values.size();
    }
    std::vector<SweepPoint> points(count);
    for (std::size_t i = 0; i < count; ++i) {
        std::size_t rest = i;
        for (std::size_t a = axes.size(); a-- > 0; rest /= axes[a].values.size())
            points[i].settings.push_back({axes[a].path, axes[a].values[rest % axes[a].values.size()]});
        std::ranges::reverse(points[i].settings);
    }
    return points;
}

// Runs of a sweep share the machine: each takes one thread, and none commands a device.
Scene alone(Scene scene) {
    scene.runtime.threads = 1;
    scene.output.clear();
    scene.record.force = true;  // the estimate is wanted, though no table is
    return scene;
}

void run_point(const Scene& scene, SweepPoint& point, const GoesOn& goes_on) {
    try {
        const Plan plan = make_plan(alone(scene.with(point.settings)));
        auto figures = run(plan, goes_on);
        if (figures)
            point.figures = figures.value();
        else
            point.refusal = figures.error().text;
    } catch (const std::exception& error) {
        point.refusal = error.what();
    }
}

}  // namespace

SweepAxis SweepAxis::from(std::string_view text) {
    const Setting setting = Setting::from(text);
    SweepAxis axis{setting.path, {""}};
    int depth = 0;
    bool quoted = false;
    for (const char byte : setting.value) {
        if (byte == '"') quoted = !quoted;
        if (!quoted && (byte == '[' || byte == '{')) ++depth;
        if (!quoted && (byte == ']' || byte == '}')) --depth;
        if (byte == ',' && depth == 0 && !quoted)
            axis.values.emplace_back();
        else if (byte != ' ' || !axis.values.back().empty())
            axis.values.back() += byte;
    }
    return axis;
}

std::vector<SweepPoint> sweep(const Scene& scene, std::span<const SweepAxis> axes,
                              const SweepOptions& options) {
    if (axes.empty()) throw SceneError({"a sweep takes at least one field and its values"});
    if (traits_of(scene.source).once)
        throw SceneError(
            {"source: standard input, pushed scans and the sensors of a hand come once, and cannot be swept "
             "over"});
    std::vector<SweepPoint> points = combinations(axes);
    // A path that is wrong is wrong everywhere, and said before anything runs.
    std::optional<SceneError> first;
    const bool any = std::ranges::any_of(points, [&](const SweepPoint& point) {
        try {
            (void)scene.with(point.settings);
            return true;
        } catch (const SceneError& error) {
            if (!first) first = error;
            return false;
        }
    });
    if (!any) throw *first;

    std::atomic<bool> stopped = false;
    std::atomic<std::uint64_t> done_millionths = 0;
    std::mutex mutex;
    std::condition_variable changed;
    bool finished = false;
    std::exception_ptr failure;
    std::jthread runner([&] {
        try {
            const std::size_t cores = std::max(1U, std::thread::hardware_concurrency());
            Workers workers(options.threads ? std::min(options.threads, cores) : cores);
            workers.run(points.size(), [&](std::size_t i) {
                std::uint64_t told = 0;
                const auto goes_on = [&](double fraction) {
                    const auto millionths = static_cast<std::uint64_t>(1e6 * std::clamp(fraction, 0.0, 1.0));
                    done_millionths += millionths - told;
                    told = millionths;
                    return !stopped;
                };
                if (stopped) return;
                run_point(scene, points[i], goes_on);
                goes_on(1);
            });
        } catch (...) {
            failure = std::current_exception();
        }
        const std::lock_guard lock(mutex);
        finished = true;
        changed.notify_one();
    });
    std::exception_ptr refused;
    std::unique_lock lock(mutex);
    while (!changed.wait_for(lock, std::chrono::milliseconds(100), [&] { return finished; })) {
        if (stopped || !options.progress) continue;
        lock.unlock();
        try {
            const double share = static_cast<double>(done_millionths) / 1e6;
            if (!options.progress(share / static_cast<double>(points.size()))) stopped = true;
        } catch (...) {
            refused = std::current_exception();
            stopped = true;
        }
        lock.lock();
    }
    lock.unlock();
    runner.join();
    if (failure) std::rethrow_exception(failure);
    if (refused) std::rethrow_exception(refused);
    return points;
}

}  // namespace afferent
