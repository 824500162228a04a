// What is wrong with a scene: the fields that break a rule, and which.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "afferent/scene/scene.hpp"

namespace afferent {

struct SceneFault {
    std::string path;   // of the field: "patch[1].neuron.tau_m_ms"
    std::string about;  // what it belongs to, where the path's numbers do not tell a reader: `patch "thumb"`
    std::string text;   // the field, the rule and the value: "neuron.tau_m_ms must be > 0, is -10"

    std::string message() const { return about.empty() ? text : about + ": " + text; }
};

class SceneFaults {
  public:
    void add(SceneFault fault) { all_.push_back(std::move(fault)); }
    // Runs a rule. A ParameterError becomes a fault of the path's field; false then.
    bool check(const std::string& path, const std::string& about, const std::function<void()>& rule);
    const std::vector<SceneFault>& all() const noexcept { return all_; }
    bool none() const noexcept { return all_.empty(); }

  private:
    std::vector<SceneFault> all_;
};

// "patch[2]"
std::string patch_path(std::size_t index);
// `patch "thumb"`
std::string about_patch(const std::string& name);

// The faults of one patch. Fields are paths within it: ".neuron".
class PatchFaults {
  public:
    PatchFaults(SceneFaults& all, std::size_t index, const std::string& name)
        : all_(all), path_(patch_path(index)), about_(about_patch(name)) {}

    void refuse(const std::string& field, std::string text) {
        all_.add({path_ + field, about_, std::move(text)});
    }
    bool check(const std::string& field, const std::function<void()>& rule) {
        return all_.check(path_ + field, about_, rule);
    }

  private:
    SceneFaults& all_;
    std::string path_;
    std::string about_;
};

// Everything that keeps a scene from being planned; none: make_plan does not throw.
std::vector<SceneFault> faults_of(const Scene& scene);

// Whether each number is in its range. Rules about several fields assume that, and are not checked where this
// is false.
bool check_ranges(const Scene& scene, SceneFaults& faults);
// The rules of everything but patches.
void check_scene(const Scene& scene, SceneFaults& faults);

// Throws ParameterError where a path is empty.
void require_path(const std::string& path, const char* field, const char* rule);

}  // namespace afferent
