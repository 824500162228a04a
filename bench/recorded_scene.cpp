#include "bench/recorded_scene.hpp"

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "bench/drives.hpp"

namespace afferent {
namespace {

// Every row has the drives of all neurons; a neuron without a new drive keeps its last.
void merge(const std::vector<NeuronDrive>& drives, TimePoint until, bench::Workload& workload) {
    for (const NeuronDrive& drive : drives)
        for (const NeuronDrive::Step& step : drive.steps)
            if (step.time < until) workload.times.push_back(step.time);
    std::sort(workload.times.begin(), workload.times.end());
    workload.times.erase(std::unique(workload.times.begin(), workload.times.end()), workload.times.end());
    workload.until = until;

    workload.drives_mv.resize(workload.rows() * workload.neurons);
    for (std::size_t i = 0; i < drives.size(); ++i) {
        double drive_mv = 0;
        auto step = drives[i].steps.begin();
        for (std::size_t row = 0; row < workload.rows(); ++row) {
            // If several drives come at one time, the last counts.
            for (; step != drives[i].steps.end() && step->time <= workload.times[row]; ++step)
                drive_mv = step->drive_mv;
            workload.drives_mv[row * workload.neurons + i] = drive_mv;
        }
    }
}

}  // namespace

bench::ErrorScene recorded_scene(const std::filesystem::path& file, bool quick) {
    const Scene scene = Scene::from_file(file);
    auto recorded = record_drives(make_plan(scene));
    if (!recorded) throw std::runtime_error(recorded.error().text);
    const std::vector<NeuronDrive>& drives = recorded.value();
    if (drives.empty()) throw std::runtime_error(file.string() + ": has no neurons");
    bench::ErrorScene result;
    bench::Workload& workload = result.workload;
    workload.name = file.stem().string();
    workload.neurons = drives.size();
    const bool alike = std::all_of(drives.begin(), drives.end(), [&](const NeuronDrive& drive) {
        return drive.parameters == drives.front().parameters;
    });
    for (const NeuronDrive& drive : drives) {
        const auto* lif = std::get_if<LifParameters>(&drive.parameters);
        if (!lif)
            throw std::runtime_error(file.string() +
                                     ": the solvers are compared on the exact neuron; this scene has " +
                                     name(drive.parameters));
        if (!alike || workload.parameters.empty()) workload.parameters.push_back(*lif);
    }
    const Duration length =
        quick ? std::min<Duration>(scene.end() - scene_start, 2s) : scene.end() - scene_start;
    merge(drives, scene_start + length, workload);
    const std::size_t judged = std::min<std::size_t>(drives.size(), quick ? 3 : 20);
    for (std::size_t k = 0; k < judged; ++k) result.judged.push_back(k * drives.size() / judged);
    return result;
}

std::vector<bench::ErrorScene> named_scenes(const std::vector<std::string>& names, bool quick) {
    std::vector<bench::ErrorScene> own = bench::error_scenes(quick);
    if (names.empty()) return own;
    std::vector<bench::ErrorScene> scenes;
    for (const std::string& name : names) {
        const auto named = std::find_if(own.begin(), own.end(),
                                        [&](const auto& scene) { return scene.workload.name == name; });
        scenes.push_back(named != own.end() ? *named : recorded_scene(name, quick));
    }
    return scenes;
}

}  // namespace afferent
