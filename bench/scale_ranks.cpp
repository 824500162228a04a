#include "bench/scale_ranks.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "afferent/scene/plan.hpp"
#include "bench/child_process.hpp"

namespace afferent::bench {
namespace {

bool is_in_path(const std::string& program) {
    const char* const path = std::getenv("PATH");
    std::istringstream folders(path ? path : "");
    for (std::string folder; std::getline(folders, folder, ':');)
        if (::access((std::filesystem::path(folder) / program).c_str(), X_OK) == 0) return true;
    return false;
}

// The population of the other rows, but under sensors that the run itself reads, with their noise.
Scene scene_of(const ScaleRun& run, double duration_s) {
    Scene scene = scale_scene(run);
    scene.duration_s = duration_s;
    scene.patches.front().sensor.full_scale_n = 2 * scale_touched_n;
    scene.source = scene::Profile{{{0, scale_touched_n * run.population.elements}}};
    return scene;
}

struct RankRun {
    double run_time_s;
    double events;
};

std::vector<std::string> run_command(const std::filesystem::path& program,
                                     const std::filesystem::path& scene) {
    return {program.string(), "run", scene.string(), "--json"};
}

RankRun result_of(ChildProcess& process, const std::string& what) {
    const auto code = process.wait(std::chrono::minutes(10));
    if (code != 0)
        throw std::runtime_error("afferent run " + what + (code ? " failed: " : " did not end: ") +
                                 process.err());
    return {number_in_json(process.out(), "run_time_s"), number_in_json(process.out(), "events")};
}

// More ranks than processors, or root, are refused by mpirun unless it is told that they are meant.
RankRun run_once(const std::filesystem::path& program, const std::filesystem::path& folder,
                 std::uint32_t ranks) {
    std::vector<std::string> command = run_command(program, folder / "scale.txtpb");
    if (ranks > 1)
        command.insert(command.begin(),
                       {"/usr/bin/env", "OMPI_ALLOW_RUN_AS_ROOT=1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1",
                        "OMPI_MCA_rmaps_base_oversubscribe=1", "mpirun", "-n", std::to_string(ranks)});
    ChildProcess process(folder, "ranks", command);
    return result_of(process, "on " + std::to_string(ranks) + " ranks");
}

// By the slower process.
double run_halves_s(const std::filesystem::path& program, const std::filesystem::path& folder) {
    const std::vector<std::string> command = run_command(program, folder / "half.txtpb");
    ChildProcess first(folder, "first half", command);
    ChildProcess second(folder, "second half", command);
    return std::max(result_of(first, "of a half").run_time_s, result_of(second, "of a half").run_time_s);
}

}  // namespace

double number_in_json(const std::string& json, const std::string& entry) {
    try {
        return nlohmann::json::parse(json).at(entry).get<double>();
    } catch (const nlohmann::json::exception& error) {
        throw std::runtime_error(entry + ": " + error.what());
    }
}

ScaleRanks measure_scale_ranks(const std::filesystem::path& program, bool quick,
                               const std::function<void(double)>& progress) {
    const auto beside = program.parent_path() / "afferent-ranks";
    if (!std::filesystem::exists(beside))
        return {.unavailable = "there is no " + beside.string() +
                               " (scripts/build.sh release -DAFFERENT_MPI=ON afferent)"};
    if (!is_in_path("mpirun"))
        return {.unavailable = "mpirun is not in PATH (scripts/install-dependencies.sh mpi)"};

    const ScaleRun run{.population = {.elements = quick ? 20'000U : 100'000U}};
    const double duration_s = quick ? 0.2 : 2;
    std::string folder_name = (std::filesystem::temp_directory_path() / "afferent-scale-XXXXXX").string();
    if (!::mkdtemp(folder_name.data())) throw std::runtime_error(folder_name + ": cannot be made");
    const std::filesystem::path folder = folder_name;
    const Scene scene = scene_of(run, duration_s);
    std::ofstream(folder / "scale.txtpb") << scene.text();
    ScaleRun half = run;
    half.population.elements /= 2;
    std::ofstream(folder / "half.txtpb") << scene_of(half, duration_s).text();
    const Plan plan = make_plan(scene);
    const double frames = duration_s / seconds(scale_frame);

    const std::vector<std::uint32_t> counts = scale_threads();
    std::vector<std::vector<double>> frame_s(counts.size());
    std::vector<double> halves_s;
    double events = -1;
    const std::size_t repeats = quick ? 1 : 5;
    for (std::size_t repeat = 0; repeat < repeats; ++repeat) {
        if (counts.size() > 1) halves_s.push_back(run_halves_s(program, folder) / frames);
        for (std::size_t i = 0; i < counts.size(); ++i) {
            const RankRun measured = run_once(program, folder, counts[i]);
            if (events >= 0 && measured.events != events)
                throw std::runtime_error("other events on " + std::to_string(counts[i]) +
                                         " ranks than in one process");
            events = measured.events;
            frame_s[i].push_back(measured.run_time_s / frames);
            progress(static_cast<double>(repeat * counts.size() + i + 1) /
                     static_cast<double>(repeats * counts.size()));
        }
    }
    std::filesystem::remove_all(folder);

    ScaleRanks found;
    if (!halves_s.empty()) found.halves_s = *std::ranges::min_element(halves_s);
    for (std::size_t i = 0; i < counts.size(); ++i) {
        std::ranges::sort(frame_s[i]);
        ScaleCost cost{.frame_s = frame_s[i][repeats / 2],
                       .least_s = frame_s[i].front(),
                       .most_s = frame_s[i].back(),
                       .least_wall_s = frame_s[i].front(),
                       .events_per_frame = events / frames,
                       .bytes = static_cast<std::size_t>(plan.bytes_per_element * plan.elements)};
        found.rows.push_back({run, cost, counts[i]});
    }
    return found;
}

}  // namespace afferent::bench
