// A population in motion as a page for a browser: runs a scene, or reads events that were recorded.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "afferent/nodes/run.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/scene/setting.hpp"

namespace afferent {

struct MovieOptions {
    double from_s = 0;
    double to_s = 0;  // 0: to the end
    double largest_mb = 32;
    // For a scene that is run.
    std::vector<Setting> settings = {};
    TableSource::Read standard_input = {};
    // Called every so often with the share of the run that is done; false stops it.
    std::function<bool(double share)> progress = {};
};

struct MovieOfPopulation {
    std::string page;
    std::uint64_t afferents = 0;
    std::uint64_t events = 0;
    TimePoint begin = scene_start;
    TimePoint end = scene_start;
    bool has_pressure = false;         // it is known what pressed the skin
    std::vector<std::string> remarks;  // what the file of events lacks, for a person
    bool is_stopped = false;           // by progress(): nothing else is filled in
};

// `from` is a scene, a recording, a folder of results or a file of events that tells where its afferents are.
// Errors name the option or the file. Throws SceneError where the scene is wrong.
Result<MovieOfPopulation> movie_of(const std::string& from, const MovieOptions& options);

}  // namespace afferent
