// What `afferent run` does, in one process or as the first of several.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "afferent/apps/live_view.hpp"
#include "afferent/apps/scene_options.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/nodes/event_exchange.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

struct RunOptions {
    SceneOptions scene;
    std::string out;
    std::string record;
    bool realtime = false;
    bool json = false;
    ViewOptions view;

    // The options that fill this in, followed by the command's others. This must not move until it is read.
    std::vector<Option> followed_by(std::vector<Option> others = {});
};

// Runs the scene, writes its results and prints the summary, to which `add_to` adds at its end. `exchange` as
// for CoprocessorEnd. Throws Failure, or Interrupted where catch_interrupts() was called.
void run_scene(const RunOptions& options, const Plan& plan, EventExchange* exchange = nullptr,
               const std::function<void(Summary&)>& add_to = {});

}  // namespace afferent
