// The rules of a scene, and what breaks them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "afferent/hand/gripper.hpp"
#include "afferent/scene/patch_plan.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// A rule that a scene breaks.
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

// Everything that keeps a scene from being planned; none: make_plan does not throw.
std::vector<SceneFault> faults_of(const Scene& scene);

// Whether each number is in its range. Rules about several fields assume that, and are not checked where this
// is false.
bool check_ranges(const Scene& scene, SceneFaults& faults);
// The rules of everything but patches.
void check_scene(const Scene& scene, SceneFaults& faults);
// The rules of its trial, if it has one.
void check_trial(const Scene& scene, SceneFaults& faults);
// The patches with everything decided; no use where there are faults.
std::vector<PatchPlan> plan_patches(const Scene& scene, SceneFaults& faults);

Gripper::Parameters gripper_parameters(const scene::Hand& hand);

// "patch[2]"
std::string patch_path(std::size_t index);
std::string about_patch(const std::string& name);

}  // namespace afferent
